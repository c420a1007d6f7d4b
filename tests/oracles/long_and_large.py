#!/usr/bin/env python3
"""Renders long sequences, large scenes and large images, and measures time, memory and open files.

    python3 tests/oracles/long_and_large.py RAYFRAME [CASE…] [--folder DIR] [--triangles N] [--side PIXELS]

Makes its inputs in a temporary folder: a sequence of 2,000 frames, a terrain of 20 million triangles, a million triangles in one place, a skin of 10,000 joints, sparse
files of several gigabytes, an image of 16,384 x 16,384 pixels. Prints a line for each case: its size, seconds, the largest resident size
(`ru_maxrss`) and the largest number of open descriptors. Ends with 1 where a bound is broken. Without cases, all are run; they need 25
gigabytes of disk (most of it holes) and, for the terrain, 6 gigabytes of memory.
"""

import argparse
import array
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

MEGABYTE = 1e6
SAMPLE_SECONDS = 0.02


class Measured:
    """Exit code, output, seconds, peak memory and samples of (frames written, resident bytes, open descriptors) of a process."""

    def __init__(self, command, written=lambda: 0):
        start = time.monotonic()
        with tempfile.TemporaryFile() as output:
            process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
            self.samples = []
            while True:
                pid, status, usage = os.wait4(process.pid, os.WNOHANG)
                if pid:
                    break
                self._sample(process.pid, written)
                time.sleep(SAMPLE_SECONDS)
            process.returncode = os.waitstatus_to_exitcode(status)
            output.seek(0)
            self.output = output.read().decode(errors="replace").strip()
        self.code, self.seconds = process.returncode, time.monotonic() - start
        self.peak = usage.ru_maxrss * 1024

    def _sample(self, pid, written):
        try:
            pages = int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1])
            descriptors = len(os.listdir(f"/proc/{pid}/fd"))
        except (FileNotFoundError, ProcessLookupError, IndexError):
            return
        self.samples.append((written(), pages * os.sysconf("SC_PAGESIZE"), descriptors))

    def descriptors(self):
        return max((sample[2] for sample in self.samples), default=0)


class Glb:
    """A .glb file that is written in parts: the sizes of its buffer views are known before their content."""

    def __init__(self, root):
        self.root, self.views, self.length = root, [], 0
        root.update(asset={"version": "2.0"}, bufferViews=[], accessors=[])

    def accessor(self, parts, count, component, kind, **bounds):
        """Adds an accessor, whose bytes the function `parts` yields. Returns its index."""
        size = count * {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind] * {5121: 1, 5123: 2, 5125: 4, 5126: 4}[component]
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": self.length, "byteLength": size})
        view = len(self.root["bufferViews"]) - 1
        accessor = {"bufferView": view, "componentType": component, "count": count, "type": kind, **bounds}
        self.root["accessors"].append(accessor)
        self.views.append((self.length, parts))
        self.length += -(-size // 4) * 4
        return len(self.root["accessors"]) - 1

    def write(self, path, bin_length=None):
        """Writes the file. A longer `bin_length` appends a hole."""
        length = bin_length or self.length
        self.root["buffers"] = [{"byteLength": length}]
        text = json.dumps(self.root).encode()
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as file:
            total = 12 + 8 + len(text) + 8 + length
            file.write(struct.pack("<4sII", b"glTF", 2, total & 0xFFFFFFFF))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", length & 0xFFFFFFFF, b"BIN\0"))
            start = file.tell()
            self._write_views(file, start)
            file.truncate(start + length)

    def write_gltf(self, path, bin_length):
        """Writes a .gltf file with a .bin file beside it, which ends in a hole."""
        self.root["buffers"] = [{"byteLength": bin_length, "uri": path.with_suffix(".bin").name}]
        path.write_text(json.dumps(self.root))
        with open(path.with_suffix(".bin"), "wb") as file:
            self._write_views(file, 0)
            file.truncate(bin_length)

    def _write_views(self, file, start):
        for offset, parts in self.views:
            file.seek(start + offset)
            for part in parts():
                file.write(part)


def floats(*values):
    return array.array("f", values).tobytes()


def triangle(animated):
    """One triangle before a camera, which turns through `animated` seconds."""
    glb = Glb({"scene": 0, "scenes": [{"nodes": [0, 1]}], "meshes": [{"primitives": [{"attributes": {}}]}]})
    glb.root["nodes"] = [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 3]}]
    glb.root["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]
    corners = lambda: [floats(-1, -1, 0, 1, -1, 0, 0, 1, 0)]
    position = glb.accessor(corners, 3, 5126, "VEC3", min=[-1, -1, 0], max=[1, 1, 0])
    glb.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = position
    if animated:
        keys = glb.accessor(lambda: [floats(0, animated)], 2, 5126, "SCALAR", min=[0], max=[animated])
        turns = glb.accessor(lambda: [floats(0, 0, 0, 1, 0, 0.7071068, 0, 0.7071068)], 2, 5126, "VEC4")
        channel = {"sampler": 0, "target": {"node": 0, "path": "rotation"}}
        glb.root["animations"] = [{"samplers": [{"input": keys, "output": turns}], "channels": [channel]}]
    return glb


def terrain(triangles):
    """A grid of hills with about so many triangles."""
    side = math.isqrt(triangles // 2)
    count = side + 1
    glb = Glb({"scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]})
    waves = [math.sin(i * 0.01) for i in range(count)]

    def positions():
        for z in range(count):
            row = array.array("f")
            for x in range(count):
                row.extend((x, 20 * waves[x] * waves[z], z))
            yield row.tobytes()

    def indices():
        for z in range(side):
            row = array.array("I")
            for x in range(side):
                corner = z * count + x
                row.extend((corner, corner + count, corner + 1, corner + 1, corner + count, corner + count + 1))
            yield row.tobytes()

    high = 20 * max(waves) ** 2
    low = 20 * max(waves) * min(waves)
    bounds = {"min": [0, min(low, -high), 0], "max": [side, high, side]}
    attributes = {"POSITION": glb.accessor(positions, count * count, 5126, "VEC3", **bounds)}
    indices = glb.accessor(indices, 6 * side * side, 5125, "SCALAR")
    glb.root["meshes"] = [{"primitives": [{"attributes": attributes, "indices": indices}]}]
    return glb, 2 * side * side


def stack(triangles):
    """One triangle, so many times."""
    glb = triangle(0)
    indices = glb.accessor(lambda: [array.array("I", [0, 1, 2] * triangles).tobytes()], 3 * triangles, 5125, "SCALAR")
    glb.root["meshes"][0]["primitives"][0]["indices"] = indices
    return glb


def skin(joints):
    """A ribbon with a joint for each of its rungs, which are children of one root."""
    glb = Glb({"scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [{"mesh": 0, "skin": 0}, {"children": list(range(2, joints + 2))}]})
    glb.root["nodes"] += [{"translation": [i * 0.01, 0, 0]} for i in range(joints)]
    count = 2 * joints
    positions = lambda: [floats(*(value for i in range(joints) for y in (0, 1) for value in (i * 0.01, y, 0)))]
    indices = lambda: [array.array("I", (v for i in range(joints - 1) for v in (2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3))).tobytes()]
    influences = lambda: [array.array("H", (v for i in range(count) for v in (i // 2, 0, 0, 0))).tobytes()]
    weights = lambda: [floats(1, 0, 0, 0) * count]
    inverses = lambda: [floats(*(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -i * 0.01, 0, 0, 1)) for i in range(joints)]
    last = struct.unpack("f", struct.pack("f", (joints - 1) * 0.01))[0]
    attributes = {
        "POSITION": glb.accessor(positions, count, 5126, "VEC3", min=[0, 0, 0], max=[last, 1, 0]),
        "JOINTS_0": glb.accessor(influences, count, 5123, "VEC4"),
        "WEIGHTS_0": glb.accessor(weights, count, 5126, "VEC4"),
    }
    glb.root["meshes"] = [{"primitives": [{"attributes": attributes, "indices": glb.accessor(indices, 6 * (joints - 1), 5125, "SCALAR")}]}]
    glb.root["skins"] = [{"joints": list(range(2, joints + 2)), "inverseBindMatrices": glb.accessor(inverses, joints, 5126, "MAT4")}]
    keys = glb.accessor(lambda: [floats(0, 1)], 2, 5126, "SCALAR", min=[0], max=[1])
    moves = glb.accessor(lambda: [floats(0, 0, 0, 0, 1, 0)], 2, 5126, "VEC3")
    channels = [{"sampler": 0, "target": {"node": node, "path": "translation"}} for node in range(3, joints + 2, 2)]
    glb.root["animations"] = [{"samplers": [{"input": keys, "output": moves}], "channels": channels}]
    return glb


class Cases:
    """The cases by name. Each returns its size, what was measured, and the list of broken bounds."""

    def __init__(self, arguments, folder):
        self.rayframe, self.folder, self.arguments = arguments.rayframe, folder, arguments

    def render(self, scene, *options, written=lambda: 0):
        return Measured([self.rayframe, "render", str(scene), "--progress", "none", "--overwrite", *map(str, options)], written)

    def sequence(self):
        frames, warm = 2000, 50
        scene, frames_folder = self.folder / "sequence.glb", self.folder / "frames"
        triangle(frames / 24).write(scene)
        frames_folder.mkdir(exist_ok=True)
        written = lambda: len(os.listdir(frames_folder))
        options = ["-f", f"0-{frames - 1}", "-r", "64x48", "--samples", "1", "-o", frames_folder / "f.####.exr"]
        measured = self.render(scene, *options, "--stats", self.folder / "s.json", "--manifest", self.folder / "m.json", written=written)
        early = [sample for sample in measured.samples if sample[0] < warm]
        late = [sample for sample in measured.samples if warm <= sample[0] < frames]
        broken = self.expect(measured, 0)
        if not early or not late:
            return f"{frames} frames", measured, [*broken, "no samples"]
        growth = max(sample[1] for sample in late) - max(sample[1] for sample in early)
        # Reports of finished frames, and the text of the manifest.
        broken += [f"memory grows by {growth / MEGABYTE:.1f} MB"] if growth > 3e3 * frames else []
        more = max(sample[2] for sample in late) - max(sample[2] for sample in early)
        broken += [f"{more} more descriptors"] if more > 0 else []
        broken += ["frames are missing"] if written() != frames else []
        return f"{frames} frames, +{growth / MEGABYTE:.1f} MB", measured, broken

    def triangles(self):
        scene = self.folder / "terrain.glb"
        glb, count = terrain(self.arguments.triangles)
        glb.write(scene)
        measured = self.render(scene, "-r", "320x180", "--samples", "1", "-o", self.folder / "t.exr")
        scene.unlink()
        each = measured.peak / count
        broken = self.expect(measured, 0) + ([f"{each:.0f} B a triangle"] if each > 450 else [])
        return f"{count / 1e6:.1f}M triangles, {each:.0f} B each", measured, broken

    def equal_centroids(self):
        """A million triangles in one place are built in at most three times the time of a million that are spread out."""
        seconds = []
        for name, glb in (("spread", terrain(1_000_000)[0]), ("equal", stack(1_000_000))):
            scene, statistics = self.folder / f"{name}.glb", self.folder / f"{name}.json"
            glb.write(scene)
            measured = self.render(scene, "-r", "32x18", "--samples", "1", "-o", self.folder / f"{name}.exr", "--stats", statistics)
            if measured.code:
                return name, measured, self.expect(measured, 0)
            phases = json.loads(statistics.read_text())["frames"][0]["seconds"]
            seconds.append(phases["total"] - phases["trace"] - phases["write"])
        ratio = seconds[1] / seconds[0]
        return f"1.0M triangles in one place, x{ratio:.2f}", measured, ["slow"] if ratio > 3 else []

    def joints(self):
        scene = self.folder / "skin.glb"
        skin(10_000).write(scene)
        measured = self.render(scene, "-f", "0-9", "-r", "320x180", "--samples", "1", "-o", self.folder / "j.####.exr")
        broken = self.expect(measured, 0) + (["slow"] if measured.seconds > 20 else [])
        return "10,000 joints, 10 frames", measured, broken

    def glb_beyond_4_gb(self):
        """A length beyond 32 bits, which a .glb cannot state."""
        scene = self.folder / "beyond.glb"
        triangle(0).write(scene, 5_000_000_000)
        measured = self.render(scene, "-r", "16x16", "-o", self.folder / "b.exr")
        scene.unlink()
        return "5.0 GB .glb", measured, self.expect(measured, 65) + self.costs_nothing(measured)

    def glb_below_4_gb(self):
        """A large chunk with a triangle at its beginning."""
        return self.sparse("3.9 GB .glb", "below.glb", lambda glb, scene: glb.write(scene, 3_900_000_000))

    def buffer_of_5_gb(self):
        """A large buffer with a triangle at its beginning."""
        return self.sparse("5.0 GB .bin", "buffer.gltf", lambda glb, scene: glb.write_gltf(scene, 5_000_000_000))

    def sparse(self, size, name, write):
        scene = self.folder / name
        write(triangle(0), scene)
        measured = self.render(scene, "-r", "16x16", "-o", self.folder / "b.exr", "--max-memory", "1G")
        for file in (scene, scene.with_suffix(".bin")):
            file.unlink(missing_ok=True)
        if measured.code == 77:
            broken = self.costs_nothing(measured)
            broken += [] if "more than the limit of 1.0 GB" in measured.output else ["the message names no limit"]
            return f"{size}, refused", measured, broken
        broken = self.expect(measured, 0) + (["more memory than the limit"] if measured.peak > 1e9 else [])
        return f"{size}, rendered", measured, broken

    def image(self):
        """An image whose pixels need more than the limit."""
        scene, output = self.folder / "image.glb", self.folder / "image.exr"
        triangle(0).write(scene)
        side = self.arguments.side
        options = ["-r", f"{side}x{side}", "--samples", "1", "--max-memory", "1G", "-o", output]
        measured = self.render(scene, *options)
        broken = self.expect(measured, 0) + (["more memory than the limit"] if measured.peak > 1.1e9 else [])
        checked = Measured([self.rayframe, "check", str(output)])
        broken += self.expect(checked, 0) + (["check needs memory"] if checked.peak > 1e8 else [])
        output.unlink(missing_ok=True)
        return f"{side}x{side} pixels", measured, broken

    def expect(self, measured, code):
        return [] if measured.code == code else [f"ended with {measured.code}: {measured.output[-300:]}"]

    def costs_nothing(self, measured):
        broken = [f"takes {measured.seconds:.1f} s"] if measured.seconds > 1 else []
        return broken + (["takes memory"] if measured.peak > 64e6 else [])


def main():
    names = [name for name in vars(Cases) if name not in ("__init__", "render", "sparse", "expect", "costs_nothing") and not name.startswith("_")]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rayframe")
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(names))
    parser.add_argument("--folder", help="a folder on a disk with space; removed files only")
    parser.add_argument("--triangles", type=int, default=20_000_000)
    parser.add_argument("--side", type=int, default=16_384)
    arguments = parser.parse_args()
    unknown = set(arguments.cases) - set(names)
    if unknown:
        parser.error(f"no such case: {', '.join(sorted(unknown))}")
    failures = 0
    print(f"{'case':<17} {'size':<36} {'seconds':>8} {'peak':>9} {'files':>6}")
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        cases = Cases(arguments, pathlib.Path(folder))
        for name in arguments.cases or names:
            size, measured, broken = getattr(cases, name)()
            failures += bool(broken)
            line = f"{name:<17} {size:<36} {measured.seconds:8.1f} {measured.peak / MEGABYTE:7.1f}MB {measured.descriptors():6}"
            print(f"{line}  {'; '.join(broken) or 'ok'}", flush=True)
            if measured.code not in (0, None):
                print(f"    {measured.output.splitlines()[-1] if measured.output else ''}", flush=True)
    print(f"{failures} of {len(arguments.cases or names)} cases break a bound")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
