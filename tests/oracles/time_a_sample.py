#!/usr/bin/env python3
"""Time of a sample by each integrator, for the table of docs/integrators.md.

    python3 tests/oracles/time_a_sample.py RAYFRAME

Renders frame 0 of four scenes at 320x180 on one thread with 16 samples by both integrators, three times in turn, and prints the least trace time (`--stats`)
of paths relative to Whitted's tree.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

SCENES = {
    "helmet": "showcase/helmet.gltf",
    "demo": "demo/whitted_1980.gltf",
    "apartment from inside": "showcase/apartment.gltf",
    "nested glass": "material/nested_glass.gltf",
}
OPTIONS = ["-q", "--overwrite", "-f", "0", "-r", "320x180", "--samples", "16", "-t", "1"]
FOLDER = pathlib.Path(__file__).parents[2] / "scenes"


def trace_seconds(program, scene, integrator, folder):
    stats = folder / "stats.json"
    command = [program, "render", FOLDER / scene, *OPTIONS, "--integrator", integrator, "--stats", stats]
    subprocess.run([*command, "-o", folder / "a.exr"], check=True, capture_output=True)
    return json.loads(stats.read_text())["frames"][0]["seconds"]["trace"]


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    print("| scene | whitted, s | path, s | ratio |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, scene in SCENES.items():
            runs = [
                [trace_seconds(program, scene, integrator, pathlib.Path(folder)) for integrator in ("whitted", "path")]
                for _ in range(3)
            ]
            whitted, path = (min(times) for times in zip(*runs))
            print(f"| {name} | {whitted:.3f} | {path:.3f} | {path / whitted:.1f} |")


if __name__ == "__main__":
    main()
