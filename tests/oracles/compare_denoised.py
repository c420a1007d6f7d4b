#!/usr/bin/env python3
"""Checks --denoise oidn against the library of Open Image Denoise, and measures what it gains.

Needs the PyPI packages `pyoidn` (which brings the program oidnDenoise), `numpy` and `OpenEXR`; not part of the default tests. Run from the project's root:
python3 tests/oracles/compare_denoised.py RAYFRAME [SAMPLES [REFERENCE_SAMPLES]]

Each scene is rendered with few samples and denoised, and again with many samples of another seed. The table shows the root mean square error of display
values of the noisy and of the denoised image, and the largest difference between the denoised image and what the library makes of the same noisy
image and guides when it is called directly.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import OpenEXR
import pyoidn

SCENES = [
    ("demo/whitted_1980.gltf", "5", []),
    ("material/nested_glass.gltf", "0", ["--env", "studio"]),
    ("texture/emissive.gltf", "0", []),
    ("showcase/apartment.gltf", "0", []),
]
SIZE = ["-r", "320x180"]


def render(program, scene, frame, output, options):
    path = Path("scenes") / scene
    common = ["render", str(path), "-o", str(output), "-f", frame, "-q", "--integrator", "path", "--exr", "float"]
    subprocess.run([program, *common, *SIZE, *options], check=True, stderr=subprocess.DEVNULL)
    channels = OpenEXR.File(str(output), separate_channels=True).channels()
    return {name: channel.pixels for name, channel in channels.items()}


def layer(channels, *names):
    return numpy.ascontiguousarray(numpy.stack([channels[name] for name in names], axis=-1), dtype=numpy.float32)


def display(colors):
    linear = numpy.clip(colors, 0.0, 1.0)
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def error(a, b):
    return float(numpy.sqrt(numpy.mean((display(a) - display(b)) ** 2)))


def library_result(colors, albedo, normal):
    """The same three filters by the library itself."""
    guides = [run_filter(albedo=albedo), run_filter(normal=normal)]
    return run_filter(color=colors, albedo=guides[0], normal=guides[1], is_clean=True)


def run_filter(color=None, albedo=None, normal=None, is_clean=False):
    device = pyoidn.Device()
    device.commit()
    ray_tracing = pyoidn.Filter(device, "RT")
    output = numpy.zeros_like(next(image for image in (color, albedo, normal) if image is not None))
    for name, image in (("color", color), ("albedo", albedo), ("normal", normal)):
        if image is not None:
            ray_tracing.set_image(name, image, pyoidn.OIDN_FORMAT_FLOAT3)
    ray_tracing.set_image("output", output, pyoidn.OIDN_FORMAT_FLOAT3)
    ray_tracing.set_bool("hdr", color is not None)
    ray_tracing.set_bool("cleanAux", is_clean)
    ray_tracing.commit()
    ray_tracing.execute()
    return output


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program = os.path.abspath(sys.argv[1])
    samples = sys.argv[2] if len(sys.argv) > 2 else "16"
    reference_samples = sys.argv[3] if len(sys.argv) > 3 else "1024"
    oidn = str(Path(pyoidn.__file__).parent / "oidn")
    print("| scene | noisy | denoised | gain | from the library |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for index, (scene, frame, options) in enumerate(SCENES):
            denoise = ["--samples", samples, "--denoise", "oidn", "--oidn", oidn, "--aovs", "denoising"]
            ours = render(program, scene, frame, folder / f"{index}.exr", options + denoise)
            truth = render(
                program, scene, frame, folder / f"{index}.true.exr",
                [*options, "--samples", reference_samples, "--seed", "1"],
            )
            truth = layer(truth, "R", "G", "B")
            noisy, denoised = layer(ours, "noisy.R", "noisy.G", "noisy.B"), layer(ours, "R", "G", "B")
            albedo = layer(ours, *(f"denoising_albedo.{c}" for c in "RGB"))
            normal = layer(ours, *(f"denoising_normal.{c}" for c in "XYZ"))
            expected = numpy.maximum(library_result(noisy, albedo, normal), 0.0)
            before, after = error(noisy, truth), error(denoised, truth)
            largest = float(numpy.abs(display(expected) - display(denoised)).max())
            print(f"| {scene} | {before:.4f} | {after:.4f} | {before / after:.1f} | {largest:.1e} |", flush=True)


main()
