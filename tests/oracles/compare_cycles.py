#!/usr/bin/env python3
"""Compares both integrators with Blender's Cycles on glTF models: mean display difference.

Needs the PyPI packages `bpy` (Python 3.11), `numpy`, `OpenEXR` and `pillow`; not part of the default tests. Run from the project's root:
python3 tests/oracles/compare_cycles.py RAYFRAME [MODEL…] [--assets DIR] [--env FILE.hdr] [--sheets DIR]

Both programs use Rayframe's camera, the same environment, frame 0 and no lights but the file's. The display difference is |a - b| of sRGB-encoded
linear light clipped to 0..1, averaged over pixels and channels. Columns: `whitted --env-samples 0`, `whitted` with its
defaults, `whitted` with 256 samples, which tells the noise of its shadows from their bias, `path`, and the ratio of the second to the first. A model is convex where little of it faces itself: there shadows of the
environment must not make the image worse; of concave models they must at least halve the difference.
Without MODEL the models of `CONCAVE` and `CONVEX` below are taken from the folder of assets. MODEL is a file, or a file and options of
`rayframe render` in one argument: "model.glb --camera-position 0,1,0".
"""

import argparse
import pathlib
import shlex
import sys

import numpy
from PIL import Image, ImageDraw

import renderers

PROJECT = pathlib.Path(__file__).resolve().parents[2]
CONCAVE = ["scenes/2CylinderEngine/2CylinderEngine.glb", "scenes/zdm2/zdm2.glb", "khronos/DamagedHelmet/glTF-Binary/DamagedHelmet.glb",
           "khronos/Suzanne/glTF/Suzanne.gltf"]
CONVEX = ["khronos/Duck/glTF-Binary/Duck.glb", "khronos/Box/glTF/Box.gltf",
          "khronos/BoxTextured/glTF/BoxTextured.gltf", "khronos/ClearCoatCarPaint/glTF-Binary/ClearCoatCarPaint.glb"]


def sheet(path, images, size):
    width, height = size
    page = Image.new("RGB", (width * len(images), height + 14), "white")
    draw = ImageDraw.Draw(page)
    for column, (name, image) in enumerate(images):
        pixels = (numpy.clip(image, 0.0, 1.0) * 255 + 0.5).astype(numpy.uint8)
        page.paste(Image.fromarray(pixels), (column * width, 14))
        draw.text((column * width + 3, 1), name, fill="black")
    page.save(path)


def compare(model, options):
    file, *own = shlex.split(model) if not pathlib.Path(model).exists() else [model]
    size = tuple(map(int, options.resolution.split("x")))
    common = ["-r", options.resolution, "--env", options.env, "-f", "0", "--depth", options.depth, *own]
    images = {}
    images["no shadows"], camera, _ = renderers.rayframe(options.program, file, *common, "--env-samples=0", "--samples=16")
    images["whitted"], _, _ = renderers.rayframe(options.program, file, *common)
    images["converged"], _, _ = renderers.rayframe(options.program, file, *common, "--samples=256")
    images["path"], _, _ = renderers.rayframe(options.program, file, *common, "--integrator=path", f"--samples={options.path_samples}")
    reference, _ = renderers.Cycles(file, camera, size, options.env, depth=options.depth).render(options.cycles_samples)
    differences = {name: renderers.difference(image, reference) for name, image in images.items()}
    if options.sheets:
        shown = [("Cycles", renderers.display(reference))]
        shown += [(f"{name} {differences[name]:.4f}", renderers.display(image)) for name, image in images.items()]
        apart = numpy.abs(renderers.display(images["path"]) - renderers.display(reference))
        shown.append(("4 |path - Cycles|", 4 * apart))
        pathlib.Path(options.sheets).mkdir(parents=True, exist_ok=True)
        sheet(pathlib.Path(options.sheets) / f"{pathlib.Path(file).stem}.png", shown, size)
        numpy.savez_compressed(pathlib.Path(options.sheets) / f"{pathlib.Path(file).stem}.npz", cycles=reference, **images)
    return pathlib.Path(file).stem, differences


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", metavar="RAYFRAME")
    parser.add_argument("models", metavar="MODEL", nargs="*")
    parser.add_argument("--assets", type=pathlib.Path, default=renderers.ASSETS, help=renderers.ASSETS_HELP)
    parser.add_argument("--env", help="environment (default: env/royal_esplanade_256.hdr of the assets)")
    parser.add_argument("--sheets", metavar="DIR", help="folder for images side by side and their values as .npz")
    parser.add_argument("-r", "--resolution", default="320x240")
    parser.add_argument("--depth", type=int, default=8)
    parser.add_argument("--path-samples", type=int, default=256)
    parser.add_argument("--cycles-samples", type=int, default=256)
    options = parser.parse_args()
    options.env = options.env or options.assets / "env/royal_esplanade_256.hdr"
    if not pathlib.Path(options.env).exists():
        parser.error(f"{options.env} is missing: pass --assets or --env")
    groups = [("given", options.models)] if options.models else [
        (kind, [str(options.assets / file) for file in files]) for kind, files in (("concave", CONCAVE), ("convex", CONVEX))]
    failed = 0
    print("| model | kind | whitted, no shadows | whitted | whitted, 256 samples | path | whitted / no shadows | verdict |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    for kind, models in groups:
        for model in models:
            name, values = compare(model, options)
            ratio = values["whitted"] / max(values["no shadows"], 1e-9)
            limit = {"concave": 0.5, "convex": 1.0}.get(kind)
            # Sampled shadows are noisy: a thousandth is no difference that anyone sees.
            misses = limit and values["whitted"] > limit * values["no shadows"] + (0.001 if kind == "convex" else 0.0)
            failed += bool(misses)
            verdict = "" if limit is None else "misses" if misses else "holds"
            print(f"| {name} | {kind} | {values['no shadows']:.4f} | {values['whitted']:.4f} | {values['converged']:.4f} | {values['path']:.4f} "
                  f"| {ratio:.2f} | {verdict} |", flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
