#!/usr/bin/env python3
"""Compares the time that checking a frame takes with the time of rendering it.

    python3 tests/oracles/verification_cost.py RAYFRAME [SCENE…] [-r 1920x1080] [--limit 0.05]

Renders one frame of each scene with the default samples, then checks it eight times in one folder (`rayframe check`), and resumes it
(`--resume`, less the time of a dry run without files, which loads the same scene). Prints the seconds of each and their ratios. The exit
code is 1 where a ratio is beyond the limit.
"""

import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ["demo/whitted_1980.gltf", "light/point.gltf", "material/nested_glass.gltf", "showcase/helmet.gltf", "showcase/level.gltf"]
COPIES = 8
ROUNDS = 3


def seconds(*command):
    best = float("inf")
    for _ in range(ROUNDS):
        start = time.perf_counter()
        subprocess.run(list(map(str, command)), check=True, capture_output=True)
        best = min(best, time.perf_counter() - start)
    return best


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rayframe")
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("-r", "--resolution", default="1920x1080")
    parser.add_argument("--limit", type=float, default=0.05)
    options = parser.parse_args()
    program = options.rayframe
    beyond = 0
    print(f"{'scene':<30} {'MB':>6} {'render':>8} {'check':>8} {'ratio':>7} {'resume':>8} {'ratio':>7}")
    for scene in options.scenes or [ROOT / "scenes" / name for name in SCENES]:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            frame = folder / "a.exr"
            render = [program, "render", scene, "-f", "0", "-r", options.resolution, "-q"]
            loading = seconds(*render, "--dry-run", "-o", folder / "none.exr")
            rendering = seconds(*render, "--overwrite", "-o", frame)
            resuming = max(0.0, seconds(*render, "--resume", "-o", frame) - loading)
            copies = folder / "copies"
            copies.mkdir()
            for index in range(COPIES):
                shutil.copy(frame, copies / f"{index}.exr")
            checking = seconds(program, "check", copies) / COPIES
            size = frame.stat().st_size / 1e6
        ratios = checking / rendering, resuming / rendering
        beyond += max(ratios) > options.limit
        name = f"{scene.parent.name}/{scene.name}"
        print(f"{name:<30} {size:6.1f} {rendering:7.2f}s {checking:7.3f}s {ratios[0]:7.2%} {resuming:7.3f}s {ratios[1]:7.2%}", flush=True)
    print(f"{beyond} beyond {options.limit:.0%}")
    sys.exit(beyond > 0)


if __name__ == "__main__":
    main()
