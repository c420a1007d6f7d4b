"""How much noise do edges have with motion blur?

    pip install OpenEXR numpy
    python tests/oracles/motion_blur_noise.py target/release/rayframe [MORE PROGRAMS] [--assets DIR]

Renders a frame of a moving character with an open shutter at several numbers of samples, by both integrators, and prints the root mean square
difference of coverage to 4096 samples of the first program, over the pixels that are partly covered: a column for each program.
"""

import argparse
import pathlib
import subprocess
import tempfile

import numpy
import OpenEXR

from renderers import ASSETS, ASSETS_HELP

SCENE = "khronos/CesiumMan/glTF-Binary/CesiumMan.glb"
SETTINGS = ["-f", "10", "-r", "96x72", "--shutter", "180deg", "--background", "none", "--exr", "float", "-q"]


def coverage(program, scene, integrator, samples):
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/frame.exr"
        options = ["--integrator", integrator, "--samples", str(samples), "-o", path]
        subprocess.run([program, "render", scene, *SETTINGS, *options], check=True, capture_output=True)
        with OpenEXR.File(path, separate_channels=True) as file:
            return file.channels()["A"].pixels.astype(numpy.float64)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--assets", type=pathlib.Path, default=ASSETS, help=ASSETS_HELP)
    args = parser.parse_args()
    scene = args.assets / SCENE
    print("| integrator | samples |", " | ".join(args.programs), "|")
    print("|---|---|" + "---|" * len(args.programs))
    for integrator in ["whitted", "path"]:
        reference = coverage(args.programs[0], scene, integrator, 4096)
        edges = (reference > 0.01) & (reference < 0.99)
        for samples in [8, 16, 64]:
            images = [coverage(program, scene, integrator, samples) for program in args.programs]
            errors = [numpy.sqrt(numpy.mean((image - reference)[edges] ** 2)) for image in images]
            print(f"| {integrator} | {samples} |", " | ".join(f"{error:.4f}" for error in errors), "|")


if __name__ == "__main__":
    main()
