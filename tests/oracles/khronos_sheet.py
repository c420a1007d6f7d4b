#!/usr/bin/env python3
"""Lays Rayframe's images of Khronos' sample models beside those that other renderers make of them.

Needs the PyPI package `pillow` with WebP; not part of the default tests. Run from the project's root:
python3 tests/oracles/khronos_sheet.py RAYFRAME OUT.png [--assets DIR] [--env FILE.hdr] [--models NAME,NAME…]

Columns: `--integrator path`, `--integrator whitted`, Cycles, V-Ray, three-gpu-pathtracer. Their images are thumbnails of
KhronosGroup/glTF-Render-Fidelity with the same cameras and another environment: materials, contact and
interreflection can be compared, highlights and brightness cannot. Blank cells have no thumbnail.
"""

import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

from PIL import Image, ImageDraw

ASSETS = pathlib.Path(__file__).resolve().parents[2] / "../shared/assets"
OTHERS = ["blender-cycles", "vray", "three-gpu-pathtracer"]
# Radius of the orbit, target, and size; the camera is on the target's +Z unless an elevation is given.
MODELS = {
    "DamagedHelmet": (3, (0, 0, 0), (768, 768)), "Avocado": (0.091, (0, 0.0314, 0), (768, 768)),
    "TransmissionTest": (1.59, (-0.15, -0.15, 0), (768, 700)), "TransmissionRoughnessTest": (1.1, (0, -0.09, 0), (768, 300)),
    "ClearCoatTest": (20, (0, 0, 0), (768, 768)), "ClearCoatCarPaint": (2, (0, 0.5, 0), (768, 768)),
    "GlassHurricaneCandleHolder": (0.75, (0, 0.13, 0), (768, 768)), "EnvironmentTest": (20, (0, 3.8, 0), (1024, 768)),
    "Suzanne": (3, (0, 0, 0), (768, 768)), "Duck": (2.7, (0, 0.86, 0), (768, 768)),
    "EmissiveStrengthTest": (12, (0, 0, 0), (1000, 600), 15), "AlphaBlendModeTest": (6, (0, 1.1, 0), (1024, 512)),
}


def camera(radius, target, elevation):
    angle = math.radians(elevation)
    position = target[0], target[1] + radius * math.sin(angle), target[2] + radius * math.cos(angle)
    return ["--camera-position", ",".join(f"{x:.6g}" for x in position), "--look-at", ",".join(map(str, target)), "--fov", "45"]


def model_file(assets, name):
    files = sorted((assets / "khronos" / name).glob("*/*.gl[bt]*"))
    return next((file for file in files if file.suffix in (".glb", ".gltf")), None)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", metavar="RAYFRAME")
    parser.add_argument("output", metavar="OUT.png")
    parser.add_argument("--assets", type=pathlib.Path, default=ASSETS,
                        help="folder with khronos/, env/ and goldens/ (default: ../shared/assets beside the project)")
    parser.add_argument("--env", help="environment (default: env/studio_small_05_1k.hdr of the assets)")
    parser.add_argument("--exposure", default="1", help="of Rayframe's images in stops, or auto (default: 1)")
    parser.add_argument("--models", help="names, separated by commas (default: all)")
    parser.add_argument("--width", type=int, default=320, help="of a cell (default: 320)")
    parser.add_argument("--samples", type=int, default=64, help="of the path integrator (default: 64)")
    options = parser.parse_args()
    if not (options.assets / "goldens").is_dir():
        parser.error(f"{options.assets} has no goldens: pass --assets")
    light = ["--env", options.env or options.assets / "env/studio_small_05_1k.hdr", "--background", "#808080", "--exposure", options.exposure]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in options.models.split(",") if options.models else MODELS:
            file = model_file(options.assets, name)
            if file is None:
                print(f"{name}: not in {options.assets / 'khronos'}, skipped", file=sys.stderr)
                continue
            radius, target, size, *elevation = MODELS[name]
            height = round(options.width * size[1] / size[0])
            cells = []
            for integrator, samples in (("path", options.samples), ("whitted", 16)):
                output = pathlib.Path(folder) / f"{integrator}.png"
                subprocess.run([options.program, "render", file, "-o", output, "-q", "--overwrite", "-r", f"{options.width}x{height}",
                                f"--integrator={integrator}", f"--samples={samples}", *map(str, light),
                                *camera(radius, target, *(elevation or [0]))], check=True)
                cells.append((integrator, Image.open(output).convert("RGB").copy()))
            for other in OTHERS:
                golden = options.assets / "goldens" / f"{name}.{other}.webp"
                if golden.exists():
                    thumbnail = Image.open(golden).convert("RGBA")
                    grey = Image.new("RGBA", thumbnail.size, "#808080")
                    flat = Image.alpha_composite(grey, thumbnail).convert("RGB")
                    cells.append((other, flat.resize((options.width, height), Image.LANCZOS)))
                else:
                    cells.append((f"{other}: none", None))
            rows.append((name, height, cells))
    if not rows:
        return 1
    page = Image.new("RGB", (options.width * (2 + len(OTHERS)), sum(height + 14 for _, height, _ in rows)), "white")
    draw, top = ImageDraw.Draw(page), 0
    for name, height, cells in rows:
        for column, (label, image) in enumerate(cells):
            draw.text((column * options.width + 3, top + 1), f"{name} {label}" if column == 0 else label, fill="black")
            if image:
                page.paste(image, (column * options.width, top + 14))
        top += height + 14
    page.save(options.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
