#!/usr/bin/env python3
"""Times `rayframe test` on a suite of 1,000 shots of which nothing, or one scene, changed since the last run.

    python3 tests/oracles/thousand_shots.py RAYFRAME [--shots N]

The shots are copies of a scene of this repository, each with another light, so that no two have the same bytes. The script ends with
an error where a run does not end as it should; the times decide nothing.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

SCENE = pathlib.Path(__file__).parents[2] / "scenes/light/point.gltf"
SUITE = """[test]
preset = "visual"
[shot]
resolution = [160, 90]
samples = 1
frames = 0
"""


def make_suite(folder, count):
    (folder / "suite.toml").write_text(SUITE)
    scene = SCENE.read_text()
    for number in range(count):
        shot = folder / f"group{number % 10}" / f"shot{number:04}.gltf"
        shot.parent.mkdir(exist_ok=True)
        shot.write_text(with_intensity(scene, 20 + number * 0.01))
    assets = SCENE.parent.glob(f"{SCENE.stem}*.bin")
    for asset in assets:
        for number in range(10):
            shutil.copy(asset, folder / f"group{number}")


def with_intensity(scene, intensity):
    document = json.loads(scene)
    for light in document["extensions"]["KHR_lights_punctual"]["lights"]:
        light["intensity"] = intensity
    return json.dumps(document)


def run(program, folder, *arguments, code=0):
    environment = {name: value for name, value in os.environ.items() if name != "CI"}
    start = time.monotonic()
    ran = subprocess.run([program, *arguments], cwd=folder, env=environment, capture_output=True, text=True)
    seconds = time.monotonic() - start
    if ran.returncode != code:
        raise SystemExit(f"{arguments}: code {ran.returncode}\n{ran.stdout[-2000:]}{ran.stderr[-2000:]}")
    return seconds, ran.stdout.strip().splitlines()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda path: str(pathlib.Path(path).resolve()))
    parser.add_argument("--shots", type=int, default=1000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        make_suite(folder, options.shots)
        run(options.program, folder, "test", "-q", code=1)
        run(options.program, folder, "accept")

        def row(what, *arguments, code=0):
            seconds, lines = run(options.program, folder, "test", *arguments, code=code)
            totals = next(line for line in reversed(lines) if " identical, " in line)
            print(f"| {what} | {seconds:.2f} s | {totals.split('; report')[0]} |")

        print("| run | wall time | result |\n|---|---|---|")
        row("all rendered")
        row("nothing changed")
        row("nothing changed, again")
        scene = folder / "group0/shot0000.gltf"
        scene.write_text(with_intensity(scene.read_text(), 50))
        row("one scene changed", code=1)
        row("the same, one of four shards", "--shard", "1/4")
        row("the same, `--no-cache`", "--no-cache", code=1)


if __name__ == "__main__":
    main()
