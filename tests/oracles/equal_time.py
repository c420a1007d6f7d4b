#!/usr/bin/env python3
"""Noise at equal time: Rayframe's path integrator beside Blender's Cycles and Mitsuba 3.

Needs the PyPI packages `bpy` (Python 3.11), `mitsuba`, `numpy`, `scipy`, `OpenEXR` and `pillow`; not part of the default tests. Mitsuba's LLVM
variant needs libLLVM 16 or later, which DRJIT_LIBLLVM_PATH names: 15 fails on AVX-512. Run from the project's root:
python3 tests/oracles/equal_time.py RAYFRAME [SCENE…] [--assets DIR] [--env FILE.hdr] [--seconds T] [--cpu-time] [--sheets DIR]

Each program renders each scene for T seconds on the same number of threads. Loading, BVH builds and compilation do not count: two
short renders give the time of a sample. The error is the RMSE against the program's own reference, which has `--reference` times as
many samples and another seed, so that models that differ do not count. It is taken on display values and on linear
light, both clipped to 0..1. `ratio` is the RMSE over Rayframe's: above 1 the other program is noisier. `--cpu-time` counts seconds
of the processor over threads instead of wall time, for machines with other work.
The last table is the slope of log RMSE over log samples of Rayframe at 4, 16, 64 and 256 samples: -0.5 or steeper.

Scenes: helmet (image textures, environment), window (closed interior, sky), glass (sphere under a lamp: caustics), lamps (1,000 emissive triangles), motion (a skinned
character that moves). Mitsuba has no moving skins and skips the last. Cycles gets the glTF file, Mitsuba the same triangles
and parameters: principled materials of textures, diffuse and dielectric ones elsewhere.
Adaptive sampling, denoising, guiding and clamps are off, everything else has its defaults; Mitsuba's sampler is `independent`.
"""

import argparse
import json
import math
import os
import pathlib
import struct
import sys
import tempfile
import time

# First, since it ships libraries that others ship, too.
try:
    import bpy  # noqa: F401
except ImportError:
    bpy = None
import numpy
from PIL import Image

import compare_mitsuba
import renderers
from compare_mitsuba import GLASS, GREY, GREEN, RED, CEILING, box, lamp, quad, sphere

mitsuba = compare_mitsuba.mitsuba


def window_interior():
    """An interior, open at a window in the wall of -X."""
    wall = [((-1.5, 0.4, 0), (0, 0, 1.5), (0, 0.4, 0)), ((-1.5, 2.1, 0), (0, 0, 1.5), (0, 0.3, 0)),
            ((-1.5, 1.3, -1.0), (0, 0, 0.5), (0, 0.5, 0)), ((-1.5, 1.3, 1.0), (0, 0, 0.5), (0, 0.5, 0))]
    return [
        (quad((0, 0, 0), (0, 0, 1.5), (1.5, 0, 0)), GREY), (quad((0, 2.4, 0), (1.5, 0, 0), (0, 0, 1.5)), GREY),
        (quad((0, 1.2, -1.5), (1.5, 0, 0), (0, 1.2, 0)), GREY), (quad((0, 1.2, 1.5), (0, 1.2, 0), (1.5, 0, 0)), GREY),
        (quad((1.5, 1.2, 0), (0, 0, 1.5), (0, 1.2, 0)), GREEN), *((quad(*part), GREY) for part in wall),
        (sphere((0.5, 0.5, -0.6), 0.5), RED), (sphere((-0.6, 0.3, -0.7), 0.3), GREY),
    ]


def thousand_lamps():
    """250 tetrahedra: closed, so that it does not matter which side shines."""
    random = numpy.random.default_rng(11)
    corners = numpy.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    faces = numpy.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    lamps = []
    for radiance in (4.0, 20.0):
        points, triangles = [], []
        for index in range(125):
            center = random.uniform((-1.1, 0.1, -1.1), (1.1, 1.9, 0.8))
            points.append(center + corners * random.uniform(0.004, 0.016))
            triangles.append(faces + 4 * index)
        lamps.append(((numpy.concatenate(points), numpy.concatenate(triangles).tolist()), lamp(radiance)))
    return [*box(), (sphere((0.0, 0.6, 0.0), 0.5), GREY), *lamps]


FRONT = ["--camera-position", "0,1,3.9", "--look-at", "0,0.9,0", "--fov", "40"]
INSIDE = ["--camera-position", "0.9,1.2,1.4", "--look-at", "-0.3,0.9,-1", "--fov", "60"]
SCENES = {
    "helmet": {"file": "khronos/DamagedHelmet/glTF-Binary/DamagedHelmet.glb", "camera": [], "sky": "hdr"},
    "window": {"objects": window_interior(), "camera": INSIDE, "sky": "sky"},
    "glass": {"objects": [*box(), (sphere((0.0, 0.6, 0.0), 0.55), GLASS), CEILING], "camera": FRONT, "sky": None},
    "lamps": {"objects": thousand_lamps(), "camera": FRONT, "sky": None},
    "motion": {"file": "khronos/CesiumMan/glTF-Binary/CesiumMan.glb", "camera": [], "sky": "hdr", "frame": 12, "shutter": 0.5},
}


def write_ply(path, points, faces, normals=None, uvs=None):
    columns, names = [points], "x y z"
    if normals is not None:
        columns, names = [*columns, normals], names + " nx ny nz"
    if uvs is not None:
        columns, names = [*columns, uvs], names + " u v"
    table = numpy.concatenate(columns, axis=1).astype("<f4")
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(table)}",
            *(f"property float {name}" for name in names.split()),
            f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header\n"]
    rows = numpy.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, numpy.asarray(faces)
    with open(path, "wb") as file:
        file.write("\n".join(head).encode() + table.tobytes() + rows.tobytes())


def glb_shapes(path, folder):
    """Mitsuba's meshes for a GLB file of textured metallic-roughness materials without skins or animation."""
    data = pathlib.Path(path).read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    document, binary = json.loads(data[20:20 + length]), data[28 + length:]
    kinds, widths = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}, {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

    def view(index):
        entry = document["bufferViews"][index]
        start = entry.get("byteOffset", 0)
        return binary[start:start + entry["byteLength"]]

    def accessor(index):
        entry = document["accessors"][index]
        width, kind = widths[entry["type"]], numpy.dtype(kinds[entry["componentType"]])
        stride = document["bufferViews"][entry["bufferView"]].get("byteStride", 0)
        if stride not in (0, width * kind.itemsize):
            raise SystemExit(f"{path}: interleaved accessors are not supported")
        values = numpy.frombuffer(view(entry["bufferView"]), kind, entry["count"] * width, entry.get("byteOffset", 0))
        return values.reshape(-1, width)

    def texture(reference, channel=None, raw=False):
        source = document["images"][document["textures"][reference["index"]]["source"]]
        name = os.path.join(folder, f"texture{reference['index']}{'' if channel is None else channel}.png")
        encoded = os.path.join(folder, "encoded")
        pathlib.Path(encoded).write_bytes(view(source["bufferView"]))
        image = Image.open(encoded).convert("RGB")
        (image if channel is None else image.getchannel(channel)).save(name)
        return {"type": "bitmap", "filename": name, "raw": raw}

    def bsdf(of):
        pbr = of.get("pbrMetallicRoughness", {})
        result = {"type": "principled", "eta": 1.5}
        color = pbr.get("baseColorFactor", [1.0] * 4)[:3]
        result["base_color"] = texture(pbr["baseColorTexture"]) if "baseColorTexture" in pbr else {"type": "rgb", "value": color}
        if "metallicRoughnessTexture" in pbr:
            result["roughness"] = texture(pbr["metallicRoughnessTexture"], 1, True)
            result["metallic"] = texture(pbr["metallicRoughnessTexture"], 2, True)
        else:
            result |= {"roughness": pbr.get("roughnessFactor", 1.0), "metallic": pbr.get("metallicFactor", 1.0)}
        if "normalTexture" in of:
            result = {"type": "normalmap", "normalmap": texture(of["normalTexture"], raw=True), "bsdf": result}
        return {"type": "twosided", "bsdf": result}

    shapes = {}

    def visit(index, parent):
        node = document["nodes"][index]
        matrix = parent @ node_matrix(node)
        for primitive in document["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            attributes = primitive["attributes"]
            points = accessor(attributes["POSITION"]) @ matrix[:3, :3].T + matrix[:3, 3]
            normals = accessor(attributes["NORMAL"]) @ numpy.linalg.inv(matrix[:3, :3])
            uvs = accessor(attributes["TEXCOORD_0"])
            name = os.path.join(folder, f"shape{len(shapes)}.ply")
            write_ply(name, points, accessor(primitive["indices"]).reshape(-1, 3).astype(int), normals, uvs)
            of = document["materials"][primitive["material"]]
            shape = {"type": "ply", "filename": name, "bsdf": bsdf(of)}
            if "emissiveTexture" in of:
                shape["emitter"] = {"type": "area", "radiance": texture(of["emissiveTexture"])}
            shapes[f"shape{len(shapes)}"] = shape
        for child in node.get("children", []):
            visit(child, matrix)

    for root in document["scenes"][document.get("scene", 0)]["nodes"]:
        visit(root, numpy.eye(4))
    return shapes


def node_matrix(node):
    if "matrix" in node:
        return numpy.array(node["matrix"], dtype=float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    matrix = numpy.eye(4)
    matrix[:3, :3] = numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]) * node.get("scale", (1, 1, 1))
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


class MitsubaScene:
    """Renders passes of at most `PASS` samples, since the LLVM variant holds all samples of a pass in memory."""

    PASS = 16

    def __init__(self, variant, scene, path, sky, camera, options, folder):
        mitsuba.set_variant(variant)
        import drjit
        drjit.set_thread_count(options.threads)
        transform = mitsuba.ScalarTransform4f
        width, height = options.size
        document = {
            "type": "scene", "integrator": {"type": "path", "max_depth": options.depth + 2},
            "sensor": {"type": "perspective", "fov": math.degrees(camera.fov_y), "fov_axis": "y",
                       "near_clip": 1e-3, "far_clip": 1e5,
                       "to_world": transform(camera.camera_to_world @ numpy.diag([-1.0, 1.0, -1.0, 1.0])),
                       "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}},
                       "sampler": {"type": "independent"}}}
        if "file" in scene:
            document |= glb_shapes(path, folder)
        else:
            for index, ((points, faces), of) in enumerate(scene["objects"]):
                name = os.path.join(folder, f"mesh{index}.ply")
                write_ply(name, points, faces)
                shape = {"type": "ply", "filename": name, "face_normals": True, "bsdf": compare_mitsuba.mitsuba_bsdf(of)}
                if of["emission"]:
                    shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": [of["emission"]] * 3}}
                document[f"mesh{index}"] = shape
        if sky:
            document["sky"] = {"type": "envmap", "filename": str(sky), "to_world": transform().rotate([0, 1, 0], 180)}
        self.scene, self.variant = mitsuba.load_dict(document), variant
        for _ in range(2):
            self.render(1)

    def render(self, samples, seed=0):
        mitsuba.set_variant(self.variant)
        passes = max(1, round(samples / self.PASS))
        each = max(1, round(samples / passes))
        total = 0.0
        begin, cpu = time.perf_counter(), time.process_time()
        for index in range(passes):
            total = total + numpy.array(mitsuba.render(self.scene, spp=each, seed=seed * 100_003 + index))[..., :3]
        taken, cpu = time.perf_counter() - begin, time.process_time() - cpu
        return total.astype(float) / passes, {"trace": taken, "total": taken, "cpu": cpu}


def programs(name, options, folder):
    """Pairs of a program's name and a function that makes its renderer; the latter returns an image and times for samples and a seed."""
    scene = SCENES[name]
    if "file" in scene:
        path = options.assets / scene["file"]
        if not path.exists():
            raise FileNotFoundError(f"{path} is missing: pass --assets")
    else:
        path = compare_mitsuba.write_gltf(scene, folder)
    mitsuba.set_variant("scalar_rgb")
    sky = {"hdr": options.env, "sky": compare_mitsuba.write_sky(folder), None: None}[scene["sky"]]
    if scene["sky"] == "sky":
        # Little of it comes in.
        mitsuba.Bitmap(8.0 * numpy.array(mitsuba.Bitmap(sky))).write(sky)
    frame, shutter = scene.get("frame", 0), scene.get("shutter")
    common = ["-r", options.resolution, "--depth", options.depth, "-f", frame, "--integrator=path", *scene["camera"],
              "--env", sky or "none", *(["--shutter", shutter] if shutter else [])]

    def rayframe(samples, seed=0):
        image, _, times = renderers.rayframe(options.program, path, *common, f"--samples={samples}", f"--seed={seed}", threads=options.threads)
        return image, times

    camera = renderers.rayframe(options.program, path, *common, "--samples=1")[1]
    yield "Rayframe", lambda: rayframe

    def cycles():
        loaded = renderers.Cycles(path, camera, options.size, sky, frame, options.depth, options.threads)
        if shutter:
            loaded.blur(shutter)
        return loaded.render

    yield "Cycles", cycles
    for variant in ("llvm_ad_rgb", "scalar_rgb"):
        if shutter:
            yield f"Mitsuba {variant}", "no moving skins"
        else:
            yield f"Mitsuba {variant}", lambda variant=variant: MitsubaScene(variant, scene, path, sky, camera, options, folder).render


def seconds(times, options):
    return times["cpu"] / options.threads if options.cpu_time else times["trace"]


def calibrate(render, options):
    """Seconds before the first sample, and of a sample."""
    few, many, first = 2, 8, seconds(render(2)[1], options)
    while True:
        last = seconds(render(many)[1], options)
        if last - first > 0.1 * options.seconds or many >= 1 << 14:
            break
        few, many, first = many, many * 4, last
    each = max(last - first, 1e-6) / (many - few)
    return max(0.0, last - many * each), each


def rmse(image, reference):
    def of(a, b):
        return math.sqrt(float(((a - b) ** 2).mean()))

    linear = [numpy.clip(numpy.nan_to_num(x), 0.0, 1.0) for x in (image, reference)]
    return of(renderers.display(image), renderers.display(reference)), of(*linear)


def slope(render):
    """Of the RMSE between two seeds over the root of two: the noise of a reference would flatten it."""
    counts = (4, 16, 64, 256)
    errors = [[e / math.sqrt(2.0) for e in rmse(render(count, seed=2)[0], render(count, seed=3)[0])] for count in counts]
    return [float(numpy.polyfit(numpy.log(counts), numpy.log([e[i] for e in errors]), 1)[0]) for i in (0, 1)], errors


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", metavar="RAYFRAME")
    parser.add_argument("scenes", metavar="SCENE", nargs="*", help=", ".join(SCENES))
    parser.add_argument("--assets", type=pathlib.Path, default=renderers.ASSETS, help=renderers.ASSETS_HELP)
    parser.add_argument("--env", type=pathlib.Path, help="environment of helmet and motion (default: env/royal_esplanade_256.hdr of the assets)")
    parser.add_argument("--seconds", type=float, default=2.0, metavar="T", help="of each program for each scene (default: 2)")
    parser.add_argument("--reference", type=float, default=8.0, metavar="X", help="samples of references, as a multiple (default: 8)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--cpu-time", action="store_true", help="seconds of the processor over threads, not wall time")
    parser.add_argument("-r", "--resolution", default="160x120")
    parser.add_argument("--depth", type=int, default=8)
    parser.add_argument("--sheets", metavar="DIR", help="folder for images of each scene: the render and the reference of each program")
    options = parser.parse_args()
    options.size = tuple(map(int, options.resolution.split("x")))
    options.env = options.env or options.assets / "env/royal_esplanade_256.hdr"
    slopes, begin = [], time.perf_counter()
    print("| scene | program | samples | seconds | RMSE display | ratio | RMSE linear | ratio |\n|---|---|---|---|---|---|---|---|", flush=True)
    for name in options.scenes or SCENES:
        own, shown = None, []
        with tempfile.TemporaryDirectory() as folder:
            for program, make in programs(name, options, folder):
                if isinstance(make, str) or program == "Cycles" and bpy is None:
                    print(f"| {name} | {program} | skipped: {make if isinstance(make, str) else 'no bpy'} | | | | | |", flush=True)
                    continue
                try:
                    render = make()
                except ImportError as error:
                    print(f"| {name} | {program} | skipped: {str(error).splitlines()[0]} | | | | | |", flush=True)
                    continue
                before, each = calibrate(render, options)
                samples = max(1, round(options.seconds / each))
                if program.startswith("Mitsuba") and samples > MitsubaScene.PASS:
                    samples -= samples % MitsubaScene.PASS
                image, times = render(samples)
                reference, _ = render(round(samples * options.reference), seed=1)
                errors = rmse(image, reference)
                if own is None:
                    own = errors
                    slopes.append((name, *slope(render)))
                print(f"| {name} | {program} | {samples} | {seconds(times, options) - before:.2f} | {errors[0]:.5f} | {errors[0] / own[0]:.2f} "
                      f"| {errors[1]:.5f} | {errors[1] / own[1]:.2f} |", flush=True)
                shown += [image, reference]
        if options.sheets:
            pathlib.Path(options.sheets).mkdir(parents=True, exist_ok=True)
            page = numpy.concatenate([renderers.display(image) for image in shown], axis=1)
            Image.fromarray((page * 255 + 0.5).astype(numpy.uint8)).save(pathlib.Path(options.sheets) / f"{name}.png")
    print("\n| scene | RMSE display at 4, 16, 64, 256 samples | slope | slope, linear |\n|---|---|---|---|")
    for name, values, errors in slopes:
        print(f"| {name} | {', '.join(f'{e[0]:.4f}' for e in errors)} | {values[0]:.3f} | {values[1]:.3f} |")
    clock = "seconds of the processor over threads" if options.cpu_time else "wall time"
    print(f"\n{options.resolution}, {options.threads} threads, {options.seconds} s ({clock}), {time.perf_counter() - begin:.0f} s in all")
    return 0


if __name__ == "__main__":
    sys.exit(main())
