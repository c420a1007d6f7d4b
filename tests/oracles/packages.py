#!/usr/bin/env python3
"""Builds each package, installs it into an empty folder, and renders with it.

    python3 tests/oracles/packages.py [--only crate,wheel,npm] [--keep FOLDER]

- crate: `cargo package`, then `cargo install` and the unit tests from the unpacked archive, which must be smaller than 5 MB;
- wheel: `packaging/python/build_wheel.py` with maturin from PyPI, then `pip install` into a new environment, pytest, mypy, and the program;
- npm: `packaging/npm/pack.mjs`, then `npm install` into a new project, and `npx rayframe`.

What is rendered by each has the bytes of the program's frame. Prints size and seconds of each step; ends with 1 where one fails. Needs cargo,
and npm for its part. CARGO_TARGET_DIR is honoured.
"""

import argparse
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGING = ROOT / "packaging"
SCENE = ROOT / "scenes/demo/whitted_1980.gltf"
RENDER = ["render", str(SCENE), "-f", "3", "-r", "64x36", "--samples", "1", "-q", "--overwrite", "-o"]
LARGEST_CRATE = 5_000_000


class Check:
    """Runs steps and remembers what failed."""

    def __init__(self, folder):
        self.folder, self.failures, self.program = folder, 0, None

    def step(self, name, command, cwd=ROOT, size=None, **env):
        start = time.monotonic()
        run = subprocess.run(list(map(str, command)), cwd=cwd, capture_output=True, text=True, env={**os.environ, **env})
        seconds = time.monotonic() - start
        text = f"{size(): 12,} B" if size and run.returncode == 0 else " " * 14
        print(f"{'ok' if run.returncode == 0 else 'FAILED':<7} {name:<34} {seconds:7.1f} s {text}", flush=True)
        if run.returncode:
            self.failures += 1
            print("\n".join((run.stdout + run.stderr).splitlines()[-15:]))
        return run

    def expect(self, name, is_true):
        print(f"{'ok' if is_true else 'FAILED':<7} {name}", flush=True)
        self.failures += not is_true

    def renders(self, name, command):
        """Whether the program renders the bytes that the crate's program renders."""
        frame = self.folder / f"{name}.exr"
        self.step(f"{name}: render", [*command, *RENDER, frame], cwd=self.folder)
        if not frame.exists():
            return
        digest = hashlib.sha256(frame.read_bytes()).hexdigest()
        self.expected = getattr(self, "expected", digest)
        self.expect(f"{name}: the frame is {digest[:8]}", digest == self.expected)

    def crate(self):
        target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
        archive = target / "package/rayframe-0.1.0.crate"
        package = ["cargo", "package", "--locked", "--allow-dirty", "--no-verify", "-p", "rayframe"]
        self.step("crate: package", package, size=lambda: archive.stat().st_size)
        self.expect(f"crate: smaller than {LARGEST_CRATE:,} B", archive.exists() and archive.stat().st_size < LARGEST_CRATE)
        with tarfile.open(archive) as files:
            files.extractall(self.folder, filter="data")
        source, program = self.folder / "rayframe-0.1.0", self.folder / "cargo/bin/rayframe"
        install = ["cargo", "install", "--locked", "--path", source, "--root", self.folder / "cargo"]
        self.step("crate: install", install, cwd=self.folder, size=lambda: program.stat().st_size)
        self.step("crate: unit tests", ["cargo", "test", "--locked", "--lib", "--bins", "--examples"], cwd=source)
        self.program = program
        self.renders("crate", [program])

    def wheel(self):
        tools, fresh, out = self.folder / "tools", self.folder / "fresh", self.folder / "wheel"
        self.step("wheel: maturin", [sys.executable, "-m", "venv", tools])
        self.step("wheel: maturin from PyPI", [tools / "bin/pip", "install", "-q", "maturin"])
        build = [tools / "bin/python", PACKAGING / "python/build_wheel.py", "--out", out]
        if self.program:
            build += ["--program", self.program]
        wheel = lambda: next(out.glob("*.whl"))
        if self.step("wheel: build", build, size=lambda: wheel().stat().st_size).returncode:
            return
        self.step("wheel: a new environment", [sys.executable, "-m", "venv", fresh])
        self.step("wheel: install", [fresh / "bin/pip", "install", "-q", f"{wheel()}[test]", "mypy"])
        self.step("wheel: pytest", [fresh / "bin/python", "-m", "pytest", "-q", PACKAGING / "python/tests"], cwd=self.folder)
        self.step("wheel: mypy", [fresh / "bin/mypy", "--strict", "-p", "rayframe"], cwd=self.folder)
        code = f"import rayframe; print(rayframe.render({str(SCENE)!r}, size=(64, 36)).shape)"
        self.step("wheel: render to an array", [fresh / "bin/python", "-c", code], cwd=self.folder)
        self.renders("wheel", [fresh / "bin/rayframe"])

    def npm(self):
        if not shutil.which("npm"):
            print("skipped npm: it is not installed")
            return
        program = self.program or shutil.which("rayframe")
        if not program:
            print("skipped npm: no program; run it with crate")
            return
        out, project = self.folder / "npm", self.folder / "project"
        machine = "arm64" if os.uname().machine == "aarch64" else "x64"
        platform = f"{'darwin' if sys.platform == 'darwin' else 'linux'}-{machine}"
        packed = lambda: sum(file.stat().st_size for file in out.glob("*.tgz"))
        self.step("npm: pack", ["node", PACKAGING / "npm/pack.mjs", out, f"{platform}={program}"], size=packed)
        project.mkdir()
        self.step("npm: a new project", ["npm", "init", "-y"], cwd=project)
        self.step("npm: install", ["npm", "install", "--no-audit", "--no-fund", *sorted(out.glob("*.tgz"))], cwd=project)
        self.renders("npm", [project / "node_modules/.bin/rayframe"])
        run = subprocess.run(["npx", "rayframe", "render", "missing.glb"], cwd=project, capture_output=True, text=True)
        self.expect("npm: npx ends with the program's exit code", run.returncode == 66)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="crate,wheel,npm")
    parser.add_argument("--keep", type=pathlib.Path, help="folder that is not removed")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.keep or pathlib.Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        check = Check(folder)
        for part in options.only.split(","):
            getattr(check, part)()
    print(f"{check.failures} failed")
    sys.exit(1 if check.failures else 0)


if __name__ == "__main__":
    main()
