#!/usr/bin/env python3
"""Hashes of images that are rendered in many ways: one for each scene, whatever the way.

    python3 tests/oracles/determinism.py [RAYFRAME] [--debug BUILD] [--aarch64 BUILD] [--only TEXT]

Builds what is not given with cargo. The ways are:

- options that may not matter: threads, SIMD levels, builders, splits, refitting, each alone and all pairs of them;
- the image in parts: crops, sample ranges and both, merged; a frame of a sequence; after SIGKILL, with `--checkpoint` or `--resume`;
- other builds: debug, and 64-bit ARM under qemu-aarch64;
- other processors: features that the C library is told to ignore, and older processors under qemu-x86_64.

The table shows the first digits of the SHA-256 of each EXR file, and the first of a scene is the one to equal. Ways whose tools are
missing are named with what installs them. At the end the program's imports of mathematical functions are listed: only those that reach
no pixel may be there. Exit code 1: a hash differs, or another function is imported.
"""

import argparse
import hashlib
import itertools
import os
import pathlib
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time

SIZE = ["-r", "96x54"]
WHITTED = ["--samples", "4"]
PATH = ["--integrator", "path", "--samples", "16"]
SCENES = {
    "demo": ["scenes/demo/whitted_1980.gltf", "-f", "5", *WHITTED],
    "demo, paths": ["scenes/demo/whitted_1980.gltf", "-f", "5", *PATH],
    "nested glass": ["scenes/material/nested_glass.gltf", "-f", "0", "--env", "outdoor", *WHITTED],
    "nested glass, paths": ["scenes/material/nested_glass.gltf", "-f", "0", "--env", "outdoor", *PATH],
    "frosted glass": ["scenes/environment/frosted_glass.gltf", "-f", "0", "--env", "studio", *WHITTED],
    "helmet on a ground": ["scenes/showcase/helmet.gltf", "-f", "0", "--ground=reflection", *WHITTED],
    "character, blurred, paths": ["scenes/showcase/character.gltf", "--animation", "walk", "-f", "5", "--shutter", "0.5", "--ground", *PATH],
    "level": ["scenes/showcase/level.gltf", "-f", "0", *WHITTED],
    "box, paths": ["scenes/path/box.gltf", "-f", "0", "--env", "none", *PATH],
    "long diagonals": ["scenes/bvh/long_diagonals.gltf", "-f", "0", *WHITTED],
}

# Options that may not change the image. The first value is the default.
DIMENSIONS = {
    "--threads": ["2", "1", "3", "7"],
    "--simd": ["best", "scalar", "sse4.2", "avx2", "avx512"],
    "--bvh": ["auto", "lbvh", "karras", "ploc"],
    "--split": ["auto", "off", "1e-3"],
    "--refit": ["auto", "off", "1.5"],
    "frames": ["one", "crops", "sequence"],
}
MASKED = ["-AVX512F", "-AVX2,-FMA,-AVX512F", "-AVX,-AVX2,-FMA,-AVX512F"]
EMULATED = ["Nehalem", "SandyBridge", "Haswell", "EPYC"]
AARCH64 = "aarch64-unknown-linux-gnu"

# Mathematical functions of the platform, and the functions of dependencies that may call them, with the reason.
MATHEMATICS = """acos asin atan atan2 cbrt cos cosh exp exp2 exp10 expm1 fma fmod hypot ldexp log log10 log1p log2 pow sin sincos sinh tan
tanh tgamma""".split()
HARMLESS_CALLERS = {
    "exr::compression::dwa::": "DWAA and DWAB files, lossy and excepted from the promise",
    "indicatif::state::": "progress bars",
    "std::sync::once::Once::call_once_force": "the cosines of DWAA and DWAB",
    "core::ops::function::FnOnce::call_once": "the cosines of DWAA and DWAB",
}


class Unsupported(Exception):
    """The processor or the scene has no such way."""


class Failed(Exception):
    """The program ended with an error."""


def run(program, *arguments, **options):
    """Runs `program`, a list whose first entries may be an emulator."""
    ended = subprocess.run([*map(str, program), *map(str, arguments)], capture_output=True, text=True, **options)
    if ended.returncode:
        message = ended.stderr.strip().splitlines()[-1] if ended.stderr.strip() else f"exit code {ended.returncode}"
        raise (Unsupported if "this machine lacks" in message else Failed)(message)


def render(program, scene, output, *options, **environment):
    variables = {"env": {**os.environ, **environment}} if environment else {}
    run(program, "render", *SCENES[scene], *SIZE, "-q", "--overwrite", "-o", output, *options, **variables)


def needs_paths(scene):
    if "path" not in SCENES[scene]:
        raise Unsupported("whitted")


# Ways: functions of a program, a scene and an empty folder that leave `out.exr` there.


def plain(*options, **environment):
    return lambda program, scene, folder: render(program, scene, folder / "out.exr", *options, **environment)


def in_parts(option, values, *others):
    def way(program, scene, folder):
        if option == "--sample-range":
            needs_paths(scene)
        parts = [folder / f"part{index}.exr" for index in range(len(values))]
        for part, value in zip(parts, values):
            render(program, scene, part, option, value, *others)
        run(program, "merge", *parts, "-o", folder / "out.exr")

    return way


CROPS = ("0,0,41,23", "41,0,96,23", "0,23,41,54", "41,23,96,54")
RANGES = ("0-3", "4-12", "13-15")


def in_ranges_of_crops(program, scene, folder):
    needs_paths(scene)
    crops = []
    for index, window in enumerate(CROPS):
        parts = [folder / f"{index}.{samples}.exr" for samples in RANGES]
        for part, samples in zip(parts, RANGES):
            render(program, scene, part, "--crop", window, "--sample-range", samples)
        crops.append(folder / f"{index}.exr")
        run(program, "merge", *parts, "-o", crops[-1])
    run(program, "merge", *crops, "-o", folder / "out.exr")


def in_a_sequence(*options):
    def way(program, scene, folder):
        frame = int(SCENES[scene][SCENES[scene].index("-f") + 1])
        sequence(program, scene, folder, frame, *options)
        (folder / f"all.{frame:04}.exr").rename(folder / "out.exr")

    return way


def sequence(program, scene, folder, frame, *options):
    arguments = list(SCENES[scene])
    arguments[arguments.index("-f") + 1] = f"{max(0, frame - 2)}-{frame + 1}"
    run(program, "render", *arguments, *SIZE, "-q", "-o", folder / "all.####.exr", *options)


def resumed(program, scene, folder):
    """Frames of one run are lost, and another one with other options renders them."""
    frame = int(SCENES[scene][SCENES[scene].index("-f") + 1])
    sequence(program, scene, folder, frame)
    (folder / f"all.{frame:04}.exr").unlink()
    sequence(program, scene, folder, frame, "--resume", "-t", "1", "--bvh", "lbvh")
    (folder / f"all.{frame:04}.exr").rename(folder / "out.exr")


def after_a_kill(*options):
    """The frame goes on from its checkpoint with `options`."""

    def way(program, scene, folder):
        needs_paths(scene)
        output, checkpoint = folder / "out.exr", folder / "out.exr.checkpoint"
        command = [*program, "render", *SCENES[scene], *SIZE, "-q", "--overwrite", "-o", output, "--checkpoint"]
        running = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while running.poll() is None and not checkpoint.exists():
            time.sleep(0.001)
        running.kill()
        running.wait()
        render(program, scene, output, "--checkpoint", *options)

    return way


def of_row(row):
    """A row of the covering array as a way."""
    options = [part for name, value in row.items() if name != "frames" for part in (name, value)]
    match row["frames"]:
        case "crops":
            return in_parts("--crop", CROPS, *options)
        case "sequence":
            return in_a_sequence(*options)
    return plain(*options)


def covering_rows(dimensions):
    """Rows in which every pair of values of two dimensions occurs, by a greedy choice."""
    names = list(dimensions)
    missing = {
        ((a, x), (b, y)) for a, b in itertools.combinations(names, 2) for x in dimensions[a] for y in dimensions[b]
    }
    rows = []
    while missing:
        row = dict(sorted(missing)[0])
        for name in names:
            if name not in row:
                def covered(value):
                    pairs = [tuple(sorted([(name, value), kept], key=lambda pair: names.index(pair[0]))) for kept in row.items()]
                    return sum(pair in missing for pair in pairs)

                row[name] = max(dimensions[name], key=covered)
        row = {name: row[name] for name in names}
        missing -= set(itertools.combinations(row.items(), 2))
        rows.append(row)
    return rows


def native_ways(program):
    ways = {"plainly": plain()}
    for option, values in DIMENSIONS.items():
        if option != "frames":
            ways |= {f"{option[2:]} {value}": plain(option, value) for value in values}
    for row in covering_rows(DIMENSIONS):
        ways[" ".join(row.values())] = of_row(row)
    ways |= {
        "four crops, merged": in_parts("--crop", CROPS),
        "three sample ranges, merged": in_parts("--sample-range", RANGES),
        "three sample ranges of one thread, merged": in_parts("--sample-range", RANGES, "-t", "1", "--simd", "scalar"),
        "sample ranges of crops, merged twice": in_ranges_of_crops,
        "a frame of a sequence": in_a_sequence(),
        "a lost frame, resumed": resumed,
        "killed, then continued": after_a_kill(),
        "killed, then continued by one thread": after_a_kill("-t", "1", "--simd", "scalar"),
    }
    return {name: (lambda scene, folder, way=way: way([program], scene, folder)) for name, way in ways.items()}


def other_builds(options):
    builds = {"debug build": [options.debug]} if options.debug else {}
    ways = {}
    for name, program in builds.items():
        ways[name] = (program, plain())
        ways[f"{name}, scalar, one thread"] = (program, plain("--simd", "scalar", "-t", "1"))
    if options.aarch64:
        emulator = [shutil.which("qemu-aarch64"), "-L", "/usr/aarch64-linux-gnu", options.aarch64]
        native = [options.aarch64] if platform.machine() == "aarch64" else emulator
        ways["64-bit ARM, NEON"] = (native, plain())
        ways["64-bit ARM, scalar"] = (native, plain("--simd", "scalar"))
        ways["64-bit ARM, one thread, no splits"] = (native, plain("-t", "1", "--split", "off"))
        ways["64-bit ARM, four crops, merged"] = (native, in_parts("--crop", CROPS))
    return ways


def other_processors(program):
    ways = {
        f"C library with {features}": ([program], plain(GLIBC_TUNABLES=f"glibc.cpu.hwcaps={features}"))
        for features in MASKED
    }
    emulator = shutil.which("qemu-x86_64")
    if not emulator:
        print("skipped: emulated processors; `apt install qemu-user` provides qemu-x86_64\n")
        return ways
    for processor in EMULATED:
        ways[f"emulated {processor}"] = ([emulator, "-cpu", processor, program], plain())
    ways["emulated Nehalem, four crops, merged"] = ([emulator, "-cpu", "Nehalem", program], in_parts("--crop", CROPS))
    return ways


def build(*arguments, **environment):
    """Builds the program with cargo; returns whether that went well."""
    command = ["cargo", "build", "-q", "--locked", "--bin", "rayframe", *arguments]
    return subprocess.run(command, env={**os.environ, **environment}).returncode == 0


def build_missing(options):
    """Builds what the command line does not name, as far as the tools are there."""
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target"))
    if not options.program:
        build("--release") or sys.exit("the release build failed")
        options.program = target / "release/rayframe"
    if not options.debug and build():
        options.debug = target / "debug/rayframe"
    if options.aarch64:
        return
    installed = subprocess.run(["rustup", "target", "list", "--installed"], capture_output=True, text=True).stdout
    missing = [
        f"`{command}`"
        for command, is_there in {
            f"rustup target add {AARCH64}": AARCH64 in installed,
            "apt install gcc-aarch64-linux-gnu libc6-dev-arm64-cross": shutil.which("aarch64-linux-gnu-gcc"),
            "apt install qemu-user": shutil.which("qemu-aarch64"),
        }.items()
        if not is_there
    ]
    if missing:
        print(f"skipped: 64-bit ARM; {' and '.join(missing)} provide what it needs\n")
    elif build("--release", "--target", AARCH64, CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER="aarch64-linux-gnu-gcc"):
        options.aarch64 = target / AARCH64 / "release/rayframe"


def cell(way, scene, expected):
    """What a way gives: the hash that the scene has, another one or none; and the text of its cell."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        try:
            way(scene, folder)
        except Unsupported as why:
            return "none", "—" if str(why) == "whitted" else f"— ({why})"
        except Failed as why:
            return "other", f"**{why}**"
        found = hashlib.sha256((folder / "out.exr").read_bytes()).hexdigest()
    is_same = found == expected.setdefault(scene, found)
    return ("same", found[:8]) if is_same else ("other", f"**{found[:8]}**")


def print_table(ways):
    """Prints the hashes; returns whether all of a scene are one."""
    print("| way | " + " | ".join(SCENES) + " |\n|---" + "|---" * len(SCENES) + "|")
    expected, results, combinations = {}, [], 0
    for name, way in ways.items():
        cells = [cell(way, scene, expected) for scene in SCENES]
        found = [result for result, _ in cells]
        results += found
        combinations += found.count("none") < len(found)
        print(f"| {name} | " + " | ".join(text for _, text in cells) + " |", flush=True)
    same, other = results.count("same"), results.count("other")
    print(f"\n{combinations} ways, {same + other} images of {len(SCENES)} scenes, {other} with another hash or failed")
    return other == 0


def imported_mathematics(program):
    """Callers of the platform's mathematical functions, by function; `None` without a disassembler."""
    disassembler = shutil.which("objdump")
    if not disassembler:
        return None
    calls = re.compile(r"<((?:" + "|".join(MATHEMATICS) + r")[fl]?)(?:@[^>]*)?>$")
    listing = subprocess.Popen(
        [disassembler, "-d", "-C", "--no-show-raw-insn", program], stdout=subprocess.PIPE, text=True, errors="replace"
    )
    caller, callers = "", {}
    for line in listing.stdout:
        if line.endswith(">:\n"):
            caller = line.split(" <", 1)[1][:-3]
        elif found := calls.search(line.rstrip()):
            callers.setdefault(found[1], set()).add(caller)
    return callers


def check_imports(program):
    """Prints who calls the platform's mathematics; returns whether none of it reaches pixels."""
    callers = imported_mathematics(program)
    if callers is None:
        print("skipped: imports of mathematical functions; `apt install binutils` provides objdump")
        return True
    harmful = 0
    print("\n| function of the platform | called by | for |\n|---|---|---|")
    for function, names in sorted(callers.items()):
        for name in sorted(names):
            reason = next((why for prefix, why in HARMLESS_CALLERS.items() if name.startswith(prefix)), None)
            harmful += reason is None
            print(f"| {function} | {name} | {reason or '**unknown**'} |")
    print(f"\n{harmful} calls of the platform's mathematics that may reach pixels")
    return harmful == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", metavar="RAYFRAME", nargs="?", type=pathlib.Path)
    parser.add_argument("--debug", metavar="BUILD", type=pathlib.Path)
    parser.add_argument("--aarch64", metavar="BUILD", type=pathlib.Path)
    parser.add_argument("--only", metavar="TEXT", default="", help="ways whose name contains it, and the plain one")
    options = parser.parse_args()
    build_missing(options)
    ways = native_ways(options.program)
    for name, (program, way) in (other_processors(options.program) | other_builds(options)).items():
        ways[name] = lambda scene, folder, program=program, way=way: way(program, scene, folder)
    ways = {name: way for name, way in ways.items() if options.only in name or name == "plainly"}
    is_same = print_table(ways)
    return 0 if check_imports(options.program) and is_same else 1


if __name__ == "__main__":
    sys.exit(main())
