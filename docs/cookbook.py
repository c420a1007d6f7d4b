#!/usr/bin/env python3
"""Runs every command of a page, and makes the images of docs/cookbook/ from what they write.

usage: docs/cookbook.py [PAGE [FOLDER]]    RAYFRAME names the program, default: rayframe. Needs PIL.

PAGE is docs/cookbook.md, or docs/compositing.md, whose commands also need oiiotool and the PyPI package OpenImageIO. Images go to
FOLDER, default: docs/cookbook. An image NAME.jpg or NAME.gif is made of NAME.png or NAME.gif. The exit code is 1 where a
command fails, or an image is nearly of one colour.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

from PIL import Image, ImageStat

DOCS = pathlib.Path(__file__).resolve().parent
WIDEST = 640


def jobs(page):
    """(title, command, images) of each section of the page that has a command; images follow it."""
    for section in re.split(r"^##+ ", page, flags=re.M)[1:]:
        title, *blocks = re.split(r"^```sh$", section, flags=re.M)
        for block in blocks:
            command, _, rest = block.partition("\n```")
            yield title.partition("\n")[0], command.strip("\n"), re.findall(r"\]\(cookbook/([\w.-]+)\)", rest)


def copy_image(source, target):
    """Copies a movie, or an image as JPEG on white; says whether there is anything in it."""
    image = Image.open(source)
    plain = Image.alpha_composite(Image.new("RGBA", image.size, "white"), image.convert("RGBA")).convert("RGB")
    if source.suffix == ".gif":
        shutil.copy(source, target)
    else:
        plain.thumbnail((WIDEST, 4 * WIDEST))
        plain.save(target, quality=85, optimize=True)
    return max(ImageStat.Stat(plain).stddev) > 5


def main():
    rayframe = shutil.which(os.environ.get("RAYFRAME", "rayframe"))
    if rayframe is None:
        sys.exit("there is no program rayframe; RAYFRAME names it")
    page = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else DOCS / "cookbook.md")
    target = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else DOCS / "cookbook").resolve()
    target.mkdir(exist_ok=True)
    failures = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "scenes").symlink_to(DOCS.parent / "scenes")
        (folder / "bin").mkdir()
        (folder / "bin/rayframe").symlink_to(os.path.realpath(rayframe))
        environment = {**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}
        for title, command, images in jobs(page.read_text()):
            start = time.monotonic()
            run = subprocess.run(["sh", "-ec", command], cwd=folder, env=environment, capture_output=True, text=True)
            print(f"{run.returncode:4}  {time.monotonic() - start:5.1f} s  {title}", flush=True)
            if run.returncode != 0:
                failures += 1
                print(run.stderr)
            for image in images if run.returncode == 0 else []:
                stem, _, extension = image.rpartition(".")
                if not copy_image(folder / f"{stem}.{'gif' if extension == 'gif' else 'png'}", target / image):
                    failures += 1
                    print(f"{image} is nearly of one colour")
    print(f"{failures} failures")
    sys.exit(failures > 0)


if __name__ == "__main__":
    main()
