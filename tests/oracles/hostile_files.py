#!/usr/bin/env python3
"""Renders malformed glTF files and bounds what each may cost.

    python3 tests/oracles/hostile_files.py RAYFRAME [FOLDER…] [--mutants 2000] [--seed 1]

The files are all .gltf and .glb files below the folders, and mutants of the scenes of this repository: bytes changed, cut, doubled or
overwritten by extreme numbers, and values of the JSON removed, swapped or replaced by extreme ones. Each is rendered at 16x16 pixels. It
must end within 5 s with a documented exit code other than 70, without a signal, with at most one line of error, and with no more memory
than 64 MB and twenty times the file and what it names. Prints counts by exit code, the most expensive files and every violation; the
exit code is 1 if there is one.
"""

import argparse
import collections
import copy
import json
import os
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import time
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
SECONDS, BASE_BYTES, TIMES = 5, 64_000_000, 20
CODES = {0, 1, 2, 65, 66, 73, 74, 75, 77}
NUMBERS = [0, -1, 1, 2, 3, 255, 65535, 2**31 - 1, 2**31, 2**32 - 1, 2**53, 2**63, 1e38, -1e38, 1e-38, 1e308, 0.5]
VALUES = [*NUMBERS, None, True, "", "x", "../x", "data:,", [], {}, [0, 0, 0], ["x"]]


def size_of(file):
    """Bytes of a file and of the files that it names."""
    size = file.stat().st_size
    try:
        if file.suffix == ".glb":
            length = struct.unpack_from("<I", file.read_bytes(), 12)[0]
            document = json.loads(file.read_bytes()[20:20 + length])
        else:
            document = json.loads(file.read_bytes())
        named = [entry.get("uri", "data:") for kind in ("buffers", "images") for entry in document.get(kind, [])]
        files = {file.parent / urllib.parse.unquote(uri) for uri in named if not uri.startswith("data:")}
        size += sum(path.stat().st_size for path in files if path.is_file())
    except (ValueError, AttributeError, TypeError, OSError, struct.error, RecursionError):
        pass
    return size


def run(program, file, output):
    """Seconds, peak bytes, exit code and lines of error of a render."""
    with tempfile.TemporaryFile() as messages:
        start = time.monotonic()
        command = [program, "render", file, "-o", output, "-r", "16x16", "-f", "0", "--samples", "1", "-q", "--overwrite"]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=messages)
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - start > SECONDS:
                process.kill()
                _, status, usage = os.wait4(process.pid, 0)
                break
            time.sleep(0.001)
        process.returncode = os.waitstatus_to_exitcode(status)
        messages.seek(0)
        lines = messages.read().decode(errors="replace").splitlines()
    return time.monotonic() - start, usage.ru_maxrss * 1024, process.returncode, [line for line in lines if ": error: " in line]


def values(document, path=()):
    """All places of a document."""
    items = document.items() if isinstance(document, dict) else enumerate(document) if isinstance(document, list) else ()
    for key, value in items:
        yield document, key
        yield from values(value)


def mutated_json(text, random_):
    document = json.loads(text)
    for _ in range(random_.choice([1, 1, 1, 2, 4])):
        places = list(values(document))
        if not places:
            break
        owner, key = random_.choice(places)
        kind = random_.randrange(4)
        if kind == 0:
            del owner[key]
        elif kind == 1:
            other, at = random_.choice(places)
            is_there = at in (other if isinstance(other, dict) else range(len(other)))
            owner[key] = copy.deepcopy(other[at]) if is_there else None
        elif isinstance(owner[key], (int, float)) and kind == 2:
            owner[key] = random_.choice(NUMBERS)
        else:
            owner[key] = random_.choice(VALUES)
    return json.dumps(document).encode()


def mutated_bytes(data, random_):
    data = bytearray(data)
    for _ in range(random_.choice([1, 1, 2, 8])):
        at = random_.randrange(len(data)) if data else 0
        kind = random_.randrange(5)
        if kind == 0 and data:
            data[at] ^= 1 << random_.randrange(8)
        elif kind == 1:
            del data[at:]
        elif kind == 2:
            data[at:at] = data[at:at + random_.randrange(1, 64)]
        elif kind == 3:
            data[at:at + 4] = struct.pack("<I", random_.choice([0, 1, 0x7F800000, 0x7FC00000, 2**31, 2**32 - 1]))
        else:
            del data[at:at + random_.randrange(1, 64)]
    return bytes(data)


def mutants(folder, count, random_):
    """Mutants of the scenes, one at a time, beside links to the files that they name."""
    scenes = sorted(path for path in (ROOT / "scenes").rglob("*.gl*") if path.suffix in (".gltf", ".glb"))
    for index in range(count):
        scene = random_.choice(scenes)
        place = folder / scene.parent.name
        if not place.exists():
            place.symlink_to(scene.parent)
        own = folder / f"own.{scene.parent.name}"
        if not own.exists():
            own.mkdir()
            for beside in scene.parent.iterdir():
                if beside.is_file() and beside.suffix not in (".gltf", ".glb", ".toml"):
                    (own / beside.name).write_bytes(beside.read_bytes())
        data = scene.read_bytes()
        if scene.suffix == ".gltf":
            data = mutated_json(data, random_) if random_.random() < 0.7 else mutated_bytes(data, random_)
        else:
            length = struct.unpack_from("<I", data, 12)[0]
            text, rest = data[20:20 + length], data[20 + length:]
            if random_.random() < 0.6:
                text = mutated_json(text, random_)
                text += b" " * (-len(text) % 4)
                data = struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON") + text + rest
            else:
                data = mutated_bytes(data, random_)
        file = own / f"{index}{scene.suffix}"
        file.write_bytes(data)
        yield file
        file.unlink()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rayframe")
    parser.add_argument("folders", nargs="*", type=pathlib.Path)
    parser.add_argument("--mutants", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the files of violations")
    options = parser.parse_args()
    codes, violations, slowest, largest = collections.Counter(), 0, (0.0, ""), (0.0, 0, "")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        given = [path for root in options.folders for path in sorted(root.rglob("*")) if path.suffix.lower() in (".gltf", ".glb")]
        made = mutants(folder, options.mutants, random.Random(options.seed))
        for file in [*given, None]:
            for file in [file] if file else made:
                seconds, peak, code, errors = run(options.rayframe, file, folder / "a.exr")
                bound = BASE_BYTES + TIMES * size_of(file)
                codes[code] += 1
                slowest = max(slowest, (seconds, file.name))
                largest = max(largest, (peak / bound, peak, file.name))
                faults = [
                    text for text, is_so in [
                        (f"took {seconds:.1f} s", seconds > SECONDS),
                        (f"ended with {code}", code not in CODES),
                        (f"used {peak / 1e6:.0f} MB, more than {bound / 1e6:.0f} MB", peak > bound),
                        (f"printed {len(errors)} errors", len(errors) != (code != 0)),
                    ] if is_so
                ]
                if faults:
                    violations += 1
                    print(f"VIOLATION {file}: {', '.join(faults)}: {(errors or [''])[0][:200]}", flush=True)
                    if options.keep:
                        options.keep.mkdir(parents=True, exist_ok=True)
                        (options.keep / file.name).write_bytes(file.read_bytes())
    total = sum(codes.values())
    print(f"{total} files ({len(given)} given, seed {options.seed}): " + ", ".join(f"exit code {code}: {count}" for code, count in sorted(codes.items())))
    print(f"slowest: {slowest[0]:.2f} s ({slowest[1]}); most memory: {largest[1] / 1e6:.0f} MB, {largest[0]:.0%} of its bound ({largest[2]})")
    print(f"{violations} violations")
    sys.exit(violations > 0)


if __name__ == "__main__":
    main()
