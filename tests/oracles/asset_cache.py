#!/usr/bin/env python3
"""Time to a small frame without an asset cache, with an empty one and with a full one, as a table.

    python3 tests/oracles/asset_cache.py RAYFRAME [SCENE ...] [--env FILE] [--side 4096] [--rounds 3] [--threads 2]

Without scenes it makes one: eight PNG images of 4096x4096 texels, each a base colour or a normal map. A frame has 16x9 pixels of one sample, so
that nearly all of its time is the import. Prints the least CPU seconds and the least seconds of all rounds, and the size of the cache; ends
with 1 where two frames of a scene differ.
"""

import argparse
import json
import os
import pathlib
import shutil
import struct
import sys
import tempfile
import time
import zlib


def png(side, seed):
    """An image whose neighbours differ by little: rows of small random differences, in the filter Sub."""
    small = bytes(((value + seed) % 9 - 4) % 256 for value in range(256))
    rows = b"".join(b"\x01" + os.urandom(side * 3).translate(small) for _ in range(side))

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(rows, 6)) + chunk(b"IEND", b"")


def large_scene(folder, side):
    """Four quads, each with a base colour and a normal map of its own."""
    for index in range(8):
        (folder / f"{index}.png").write_bytes(png(side, index))
    positions = struct.pack("<12f", -1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1)
    coordinates = struct.pack("<8f", 0, 0, 1, 0, 1, 1, 0, 1)
    (folder / "quad.bin").write_bytes(positions + coordinates + struct.pack("<6H", 0, 2, 1, 0, 3, 2))
    views = [(0, 48), (48, 32), (80, 12)]
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}
    materials = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 2 * i}}, "normalTexture": {"index": 2 * i + 1}} for i in range(4)]
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2, 3]}],
        "nodes": [{"mesh": i, "translation": [2.2 * i, 0, 0]} for i in range(4)],
        "meshes": [{"primitives": [{**primitive, "material": i}]} for i in range(4)],
        "materials": materials,
        "textures": [{"source": i} for i in range(8)],
        "images": [{"uri": f"{i}.png"} for i in range(8)],
        "buffers": [{"uri": "quad.bin", "byteLength": 92}],
        "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": length} for start, length in views],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4, "min": [-1, 0, -1], "max": [1, 0, 1]},
            {"bufferView": 1, "componentType": 5126, "type": "VEC2", "count": 4},
            {"bufferView": 2, "componentType": 5123, "type": "SCALAR", "count": 6},
        ],
    }
    path = folder / "large.gltf"
    path.write_text(json.dumps(document))
    return path


def run(command):
    """CPU seconds and seconds of a command that must succeed."""
    start = time.monotonic()
    child = os.posix_spawnp(command[0], command, os.environ)
    _, status, usage = os.wait4(child, 0)
    if status != 0:
        sys.exit(f"{command} ended with {os.waitstatus_to_exitcode(status)}")
    return usage.ru_utime + usage.ru_stime, time.monotonic() - start


def measure(options, scene, folder):
    """A row of the table, and whether all frames are equal."""
    frame, cache = folder / "a.exr", folder / "cache"
    command = [options.rayframe, "render", str(scene), "-f", "0", "-r", "16x9", "--samples", "1", "-q", "--overwrite"]
    command += ["-o", str(frame), "-t", str(options.threads), *(["--env", options.env] if options.env else [])]
    cached = [*command, "--asset-cache", str(cache)]
    times, frames = {"without": [], "empty": [], "full": []}, set()
    for _ in range(options.rounds):
        shutil.rmtree(cache, ignore_errors=True)
        for name, arguments in (("without", command), ("empty", cached), ("full", cached)):
            times[name].append(run(arguments))
            frames.add(frame.read_bytes())
    size = sum(file.stat().st_size for file in cache.glob("*")) if cache.is_dir() else 0
    cells = [f"{min(cpu for cpu, _ in pairs):.2f} ({min(wall for _, wall in pairs):.2f})" for pairs in times.values()]
    return f"| {scene.name} | {' | '.join(cells)} | {size / 1e6:.0f} MB |", len(frames) == 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rayframe")
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--env")
    parser.add_argument("--side", type=int, default=4096)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    options.rayframe = str(pathlib.Path(options.rayframe).resolve())
    with tempfile.TemporaryDirectory() as folder:
        folder, is_same = pathlib.Path(folder), True
        scenes = options.scenes or [large_scene(folder, options.side)]
        print("| scene | without | empty cache | full cache | size |\n|---|---|---|---|---|")
        for scene in scenes:
            row, same = measure(options, scene, folder)
            print(row, flush=True)
            is_same &= same
    sys.exit(0 if is_same else "frames of a scene differ")


if __name__ == "__main__":
    main()
