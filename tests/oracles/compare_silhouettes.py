#!/usr/bin/env python3
"""Compares the silhouettes of models under --orbit and --view with those that F3D draws from the same camera.

Needs the PyPI packages `f3d` (4 or later), `OpenEXR`, `numpy` and `pillow`, and a display-less OpenGL (EGL); not part of the default
tests. Run from the project's root: python3 tests/oracles/compare_silhouettes.py RAYFRAME FILE…

The direction of each view is computed here from its angles: from the asset, the camera is at (sin az cos el, sin el, cos az cos el).
The position that Rayframe wrote into the EXR file must lie in that direction, to a thousandth; F3D looks along it. The printed
figure is the intersection of both silhouettes over their union. At or below 0.97 a view counts as wrong.
"""

import math
import os
import subprocess
import sys
import tempfile

import f3d
import numpy
import OpenEXR
from PIL import Image

SIZE = 640, 480
LIMIT = 0.97
VIEWS = {
    "--view=front": (0, 0), "--view=back": (180, 0), "--view=right": (90, 0), "--view=left": (-90, 0),
    "--view=three-quarter": (30, 20), "--orbit=40,15": (40, 15), "--orbit=-120,-35": (-120, -35),
    "--orbit=200,70,1.5": (200, 70),
}


def direction(azimuth, elevation):
    az, el = math.radians(azimuth), math.radians(elevation)
    return numpy.array([math.sin(az) * math.cos(el), math.sin(el), math.cos(az) * math.cos(el)])


def rayframe(program, model, view, folder):
    """Coverage, camera to world, and vertical field of view."""
    path = os.path.join(folder, "view.exr")
    size = f"{SIZE[0]}x{SIZE[1]}"
    command = [program, "render", model, view, "-o", path, "-r", size, "--background=none", "--animation=none"]
    subprocess.run(command + ["--overwrite", "-q", "--fov=30"], check=True)
    file = OpenEXR.File(path)
    header, channels = file.header(), file.channels()
    alpha = (channels["A"] if "A" in channels else channels["RGBA"]).pixels
    alpha = alpha[..., 3] if alpha.ndim == 3 else alpha
    # OpenEXR's matrices multiply rows.
    world_from_camera = numpy.linalg.inv(numpy.array(header["worldToCamera"]).T)
    return alpha > 0.5, world_from_camera


def f3d_silhouette(model, position, backward, folder):
    engine = f3d.Engine.create_egl()
    engine.window.size = SIZE
    options = {"ui.axis": False, "render.grid.enable": False, "render.background.color": [1.0, 0.0, 1.0]}
    for name, value in options.items():
        engine.options[name] = value
    engine.scene.add(model)
    camera = engine.window.camera
    camera.position = tuple(position)
    camera.focal_point = tuple(position - backward)
    camera.view_up = (0.0, 1.0, 0.0)
    camera.view_angle = 30.0
    path = os.path.join(folder, "f3d.png")
    engine.window.render_to_image(False).save(path)
    pixels = numpy.asarray(Image.open(path).convert("RGB")).astype(int)
    background = numpy.array([255, 0, 255])
    return numpy.abs(pixels - background).sum(axis=-1) > 6


def main():
    f3d.Log.set_verbose_level(f3d.Log.VerboseLevel.QUIET)
    program, models = sys.argv[1], sys.argv[2:]
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for model in models:
            for view, angles in VIEWS.items():
                ours, world_from_camera = rayframe(program, model, view, folder)
                expected = direction(*angles)
                error = numpy.abs(world_from_camera[:3, 2] - expected).max()
                theirs = f3d_silhouette(model, world_from_camera[:3, 3], expected, folder)
                iou = (ours & theirs).sum() / max((ours | theirs).sum(), 1)
                is_wrong = iou <= LIMIT or error > 1e-3
                wrong += is_wrong
                print(f"{os.path.basename(model):<32} {view:<22} direction off by {error:.1e}  IoU {iou:.4f}"
                      + ("  WRONG" if is_wrong else ""), flush=True)
    print(f"{wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
