#!/usr/bin/env python3
"""Builds the wheel with the program in it.

    python3 packaging/python/build_wheel.py [--program FILE] [--out FOLDER] [MATURIN OPTIONS…]

Needs maturin (`pip install maturin`). Without `--program`, the program is built first. Prints the wheel's path.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
ROOT = FOLDER.parents[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, default=FOLDER / "dist")
    options, more = parser.parse_known_args()
    # Maturin runs in another folder.
    options.out = options.out.resolve()
    program = options.program
    if program is None:
        subprocess.run(["cargo", "build", "--release", "--locked"], cwd=ROOT, check=True)
        target = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
        program = target / "release" / ("rayframe.exe" if os.name == "nt" else "rayframe")
    scripts = FOLDER / "rayframe.data/scripts"
    shutil.rmtree(scripts.parent, ignore_errors=True)
    scripts.mkdir(parents=True)
    # The command has this name, whatever the file is called.
    shutil.copy(program, scripts / ("rayframe.exe" if program.suffix == ".exe" else "rayframe"))
    for licence in ROOT.glob("LICENSE-*"):
        shutil.copy(licence, FOLDER)
    options.out.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "maturin", "build", "--release", "--locked", "--out", options.out, *more]
    subprocess.run(command, cwd=FOLDER, check=True)
    print(max(options.out.glob("rayframe-*.whl"), key=lambda wheel: wheel.stat().st_mtime))


if __name__ == "__main__":
    main()
