#!/usr/bin/env python3
"""Compares the memory that `rayframe render` estimates with the peak that it uses.

    python3 tests/oracles/memory_estimates.py RAYFRAME [SCENE…] [--resolutions 64x64,512x512,2048x1024] [--limit 1.3] [--options OPTIONS]

The estimate of a render is the smallest `--max-memory` with which `--dry-run` plans whole frames, no bands, found by bisection. The peak is the largest
resident size of the process (`ru_maxrss`), with everything in it. Without scenes, the two largest of each folder of this repository are taken. Prints a line
for each scene, split, set of AOVs and resolution, and ends with 1 where a ratio of the two lies beyond the limit. `--options` are
further options of all renders, such as "--integrator path" or "-f 0-3".
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["bvh", "geometry", "environment", "texture", "skin", "morph", "path", "light", "showcase", "storage", "material"]
SPLITS = ["auto", "off"]
AOVS = ["beauty", "all"]


def default_scenes():
    """The two largest scenes of each folder."""
    scenes = []
    for folder in FOLDERS:
        files = sorted((ROOT / "scenes" / folder).glob("*.gl*"), key=lambda file: -file.stat().st_size)
        scenes += [file for file in files if file.suffix in (".gltf", ".glb")][:2]
    return scenes


def run(command):
    """Exit code and peak resident bytes of a process."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage.ru_maxrss * 1024


def estimate(command):
    """The smallest limit in bytes, within 2 %, of which a dry run says that it suffices for whole frames."""

    def accepts(limit):
        plan = [*command, "--progress", "json", "--dry-run", "--max-memory", str(int(limit))]
        planned = subprocess.run(plan, capture_output=True, text=True)
        return planned.returncode == 0 and "band_rows" not in planned.stdout

    low, high = 1e5, 64e9
    if not accepts(high):
        return None
    while high / low > 1.02:
        middle = (low * high) ** 0.5
        low, high = (low, middle) if accepts(middle) else (middle, high)
    return high


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rayframe")
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--resolutions", default="64x64,512x512,2048x1024")
    parser.add_argument("--limit", type=float, default=1.3)
    parser.add_argument("--options", type=str.split, default=[])
    arguments = parser.parse_args()
    worst, beyond, count = 1.0, 0, 0
    print(f"{'scene':<40} {'split':<5} {'AOVs':<7} {'resolution':<10} {'estimate':>9} {'peak':>9} {'ratio':>6}")
    for scene in arguments.scenes or default_scenes():
        for resolution in arguments.resolutions.split(","):
            for split in SPLITS:
                for aovs in AOVS:
                    with tempfile.TemporaryDirectory() as folder:
                        command = [arguments.rayframe, "render", str(scene), "-r", resolution]
                        command += arguments.options
                        for option, value in (("-f", "0"), ("--samples", "1")):
                            command += [] if option in arguments.options else [option, value]
                        command += ["--split", split, "--aovs", aovs, "-o", f"{folder}/a.####.exr"]
                        estimated = estimate(command)
                        code, peak = run([*command, "--progress", "none"])
                    name = f"{scene.parent.name}/{scene.name}"
                    if estimated is None or code != 0:
                        print(f"{name:<40} {split:<5} {aovs:<7} {resolution:<10} not rendered")
                        beyond += 1
                        continue
                    ratio = estimated / peak
                    count += 1
                    worst = max(worst, ratio, 1 / ratio)
                    beyond += max(ratio, 1 / ratio) > arguments.limit
                    print(
                        f"{name:<40} {split:<5} {aovs:<7} {resolution:<10} {estimated / 1e6:7.1f}MB {peak / 1e6:7.1f}MB {ratio:6.2f}",
                        flush=True,
                    )
    print(f"{count} renders, the worst is off by {worst:.2f}, {beyond} are beyond {arguments.limit} or failed")
    sys.exit(1 if beyond else 0)


if __name__ == "__main__":
    main()
