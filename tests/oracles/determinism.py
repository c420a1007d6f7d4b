#!/usr/bin/env python3
"""Hashes of images that are rendered in many ways: one for each scene, whatever the way.

Needs Python alone. Run from the project's root: python3 tests/oracles/determinism.py RAYFRAME [OTHER_BUILD…]
The ways are thread counts, SIMD levels, builders, splits, crops and sample ranges that are merged, frames that continue from a checkpoint after
SIGKILL, frames of sequences, and the other builds of the program, such as debug ones. The table shows the first digits of the SHA-256 of the
EXR file. Exit code 1: a hash differs.
"""

import argparse
import hashlib
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

SIZE = ["-r", "160x90"]
WHITTED = ["--samples", "4"]
PATH = ["--integrator", "path", "--samples", "16"]
SCENES = {
    "demo": ["scenes/demo/whitted_1980.gltf", "-f", "5", *WHITTED],
    "demo, paths": ["scenes/demo/whitted_1980.gltf", "-f", "5", *PATH],
    "nested glass": ["scenes/material/nested_glass.gltf", "-f", "0", "--env", "outdoor", *WHITTED],
    "nested glass, paths": ["scenes/material/nested_glass.gltf", "-f", "0", "--env", "outdoor", *PATH],
    "helmet": ["scenes/showcase/helmet.gltf", "-f", "0", *WHITTED],
    "character, blurred, paths": ["scenes/showcase/character.gltf", "--animation", "walk", "-f", "5", "--shutter", "0.5", "--ground", *PATH],
    "level": ["scenes/showcase/level.gltf", "-f", "0", *WHITTED],
    "box, paths": ["scenes/path/box.gltf", "-f", "0", "--env", "none", *PATH],
    "long diagonals": ["scenes/bvh/long_diagonals.gltf", "-f", "0", *WHITTED],
}
OPTIONS = {
    "1 thread": ["-t", "1"],
    "2 threads": ["-t", "2"],
    "7 threads": ["-t", "7"],
    "scalar": ["--simd", "scalar"],
    "SSE4.2": ["--simd", "sse4.2"],
    "AVX2": ["--simd", "avx2"],
    "AVX-512": ["--simd", "avx512"],
    "LBVH": ["--bvh", "lbvh"],
    "PLOC": ["--bvh", "ploc"],
    "no splits": ["--split", "off"],
    "splits": ["--split", "1e-3"],
    "no refitting": ["--refit", "off"],
}


class Unsupported(Exception):
    """The processor or the scene has no such way."""


def run(program, *arguments):
    ended = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if ended.returncode:
        raise Unsupported(ended.stderr.strip().splitlines()[-1] if ended.stderr.strip() else f"exit code {ended.returncode}")


def render(program, scene, output, *options):
    run(program, "render", *SCENES[scene], *SIZE, "-q", "--overwrite", "-o", output, *options)


def in_parts(program, scene, folder, option, values):
    parts = [folder / f"part{index}.exr" for index in range(len(values))]
    for part, value in zip(parts, values):
        render(program, scene, part, option, value)
    run(program, "merge", *parts, "-o", folder / "out.exr")


def in_crops(program, scene, folder):
    in_parts(program, scene, folder, "--crop", ("0,0,70,41", "70,0,160,41", "0,41,70,90", "70,41,160,90"))


def in_sample_ranges(program, scene, folder):
    if "path" not in SCENES[scene]:
        raise Unsupported("whitted")
    in_parts(program, scene, folder, "--sample-range", ("0-3", "4-12", "13-15"))


def after_a_kill(program, scene, folder):
    if "path" not in SCENES[scene]:
        raise Unsupported("whitted")
    output, checkpoint = folder / "out.exr", folder / "out.exr.checkpoint"
    command = [program, "render", *SCENES[scene], *SIZE, "-q", "--overwrite", "-o", output, "--checkpoint"]
    running = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while running.poll() is None and not checkpoint.exists():
        time.sleep(0.001)
    running.send_signal(signal.SIGKILL)
    running.wait()
    render(program, scene, output, "--checkpoint")


def in_a_sequence(program, scene, folder):
    arguments = list(SCENES[scene])
    frame = int(arguments[arguments.index("-f") + 1])
    arguments[arguments.index("-f") + 1] = f"{max(0, frame - 2)}-{frame + 1}"
    run(program, "render", *arguments, *SIZE, "-q", "--overwrite", "-o", folder / "all.####.exr")
    (folder / f"all.{frame:04}.exr").rename(folder / "out.exr")


def plain(program, scene, folder, *options):
    render(program, scene, folder / "out.exr", *options)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", metavar="RAYFRAME")
    parser.add_argument("others", metavar="OTHER_BUILD", nargs="*")
    options = parser.parse_args()
    ways = {"": lambda scene, folder: plain(options.program, scene, folder)}
    for name, way in OPTIONS.items():
        ways[name] = lambda scene, folder, way=way: plain(options.program, scene, folder, *way)
    for name, way in (("four crops, merged", in_crops), ("three sample ranges, merged", in_sample_ranges),
                      ("killed, then continued", after_a_kill), ("in a sequence", in_a_sequence)):
        ways[name] = lambda scene, folder, way=way: way(options.program, scene, folder)
    for other in options.others:
        ways[other] = lambda scene, folder, other=other: plain(other, scene, folder)

    print("| way | " + " | ".join(SCENES) + " |\n|---" + "|---" * len(SCENES) + "|")
    expected, different, combinations = {}, 0, 0
    for name, way in ways.items():
        cells = []
        for scene in SCENES:
            with tempfile.TemporaryDirectory() as folder:
                folder = pathlib.Path(folder)
                try:
                    way(scene, folder)
                except Unsupported as why:
                    cells.append("—" if str(why) == "whitted" else f"— ({why})")
                    continue
                found = hashlib.sha256((folder / "out.exr").read_bytes()).hexdigest()
            combinations += 1
            is_same = found == expected.setdefault(scene, found)
            different += not is_same
            cells.append(found[:8] if is_same else f"**{found[:8]}**")
        print(f"| {name or 'plainly'} | " + " | ".join(cells) + " |", flush=True)
    print(f"\n{combinations} images of {len(SCENES)} scenes, {different} with another hash")
    return different > 0


if __name__ == "__main__":
    sys.exit(main())
