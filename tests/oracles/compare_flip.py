"""Compares the FLIP of `rayframe diff` with that of the published tool, on renders of Rayframe's scenes and modified copies of them.

    cargo build --release
    pip install flip-evaluator OpenEXR pillow numpy
    python tests/oracles/compare_flip.py [target/release/rayframe]

Images of light that are mostly black have other exposures by intent: the published
tool gets them from us. Light is compared without a tone curve as well, at exposures of ours: expected is the larger of what the tool finds for
both. Prints a line per pair. The exit code is 1 if a mean or a pixel differs by more than 1e-3.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import flip_evaluator
import numpy
import OpenEXR
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/rayframe")
LIMIT = 1e-3


def read_png(path):
    return numpy.asarray(Image.open(path).convert("RGB")).astype(numpy.float32) / 255


def write_png(path, values):
    Image.fromarray((numpy.clip(values, 0, 1) * 255 + 0.5).astype(numpy.uint8)).save(path)


def read_exr(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        names = ["Y"] if "Y" in channels else ["R", "G", "B"]
        return numpy.stack([channels[name].pixels.astype(numpy.float32) for name in names], axis=-1)


def write_exr(path, values):
    channels = {name: numpy.ascontiguousarray(values[..., i].astype(numpy.float16)) for i, name in enumerate("RGB")}
    channels["A"] = numpy.ones(values.shape[:2], numpy.float16)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))


def replace_block(values, random):
    values[40:80, 100:140] = values[30, 20]


def invert_block(values, random):
    values[50:56, 60:66] = 1 - numpy.clip(values[50:56, 60:66], 0, 1)


def shift(values, random):
    values[:] = numpy.roll(values, 1, axis=1)


def noise(values, random):
    values += random.normal(0, 0.01, values.shape).astype(numpy.float32)
    numpy.maximum(values, 0, out=values)


def exposure(values, random):
    values *= 1.02


def firefly(values, random):
    values[20, 200] = 50


def hue(values, random):
    values[:, 150:] = values[:, 150:, ::-1].copy()


# Scene, frame, modification.
PAIRS = [
    ("demo/whitted_1980", 0, replace_block),
    ("demo/whitted_1980", 5, invert_block),
    ("material/metal_roughness_row", 0, shift),
    ("texture/chequer_to_horizon", 0, noise),
    ("light/two_lights_shadows", 0, exposure),
    ("geometry/instancing", 0, firefly),
    ("skin/many_influences", 0, hue),
    ("demo/whitted_1980", 3, shift),
]


def encode_srgb(light):
    curve = 1.055 * numpy.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055
    return numpy.where(light <= 0.0031308, 12.92 * light, curve).astype(numpy.float32)


def plane(flip, values):
    return numpy.asarray(flip).reshape(values.shape[0], values.shape[1], -1)[..., 0]


def compare(folder, kind, number, pair):
    scene, frame, modify = pair
    ending, read, write = {"LDR": ("png", read_png, write_png), "HDR": ("exr", read_exr, write_exr)}[kind]
    rendered, reference, test = (folder / f"{name}{number}.{ending}" for name in ("rendered", "reference", "test"))
    command = [PROGRAM, "render", ROOT / "scenes" / f"{scene}.gltf", "-o", rendered, "-f", str(frame), "-r", "251x141", "-q"]
    subprocess.run(command, check=True)
    values = read(rendered)
    write(reference, values)
    values = read(reference).copy()
    modify(values, numpy.random.default_rng(number))
    write(test, values)
    map_file = folder / f"map{number}.exr"
    command = [PROGRAM, "diff", test, reference, "--layers", "beauty", "--json", "--flip-map", map_file]
    run = subprocess.run(command, stdout=subprocess.PIPE)
    assert run.returncode in (0, 1), run
    ours = json.loads(run.stdout)["frames"][0]
    is_black = kind == "HDR" and numpy.median(read(reference)) < 1e-6
    ranges = {"startExposure": ours["exposures"]["start"], "stopExposure": ours["exposures"]["stop"]} if is_black else {}
    theirs, mean, parameters = flip_evaluator.evaluate(
        read(reference), read(test), kind, applyMagma=False, parameters=ranges)
    theirs = plane(theirs, values)
    for factor in (ours["exposures"] or {}).get("linear", []):
        shown = [encode_srgb(numpy.clip(read(path) * factor, 0, 1)) for path in (reference, test)]
        theirs = numpy.maximum(theirs, plane(flip_evaluator.evaluate(*shown, "LDR", applyMagma=False)[0], values))
    pixels = numpy.abs(read_exr(map_file)[..., 0] - theirs).max()
    means = abs(ours["flip"]["mean"] - float(theirs.astype(numpy.float64).mean()))
    exposures = ""
    if kind == "HDR":
        found = ours["exposures"]
        exposures = f"{found['count']} exposures (theirs {parameters['numExposures']})"
        assert found["count"] == parameters["numExposures"], (found, parameters)
    print(f"{kind} {scene} {frame} {modify.__name__}: mean {ours['flip']['mean']:.6f}, theirs {mean:.6f};"
          f" largest difference of a pixel {pixels:.1e} {exposures}")
    return max(means, pixels)


def main():
    with tempfile.TemporaryDirectory() as folder:
        jobs = [(kind, pair) for kind in ("LDR", "HDR") for pair in PAIRS]
        worst = max(compare(pathlib.Path(folder), kind, number, pair) for number, (kind, pair) in enumerate(jobs))
    print(f"{len(jobs)} pairs, the largest difference is {worst:.1e}; the limit is {LIMIT:.0e}")
    sys.exit(1 if worst > LIMIT else 0)


if __name__ == "__main__":
    main()
