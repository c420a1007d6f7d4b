#!/usr/bin/env python3
"""Compares --integrator path with the path integrator of Mitsuba 3, pixel by pixel.

Needs the PyPI packages `mitsuba` (3.5 or later), `numpy`, `scipy` and `OpenEXR`; not part of the default tests. Run from the project's root:
python3 tests/oracles/compare_mitsuba.py RAYFRAME [SCENE…]

Both programs render each scene several times with different seeds. The means of a pixel are compared by Welch's t-test. Of many pixels some
differ by chance, so the significance level is corrected for their number (Šidák): a scene passes where no pixel has a p-value below
1 − (1 − 0.01)^(1/pixels). Materials are those that both programs define alike: diffuse, smooth and nearly smooth conductors of reflectance 1, smooth
and nearly smooth dielectrics, emissive ones.
"""

import base64
import json
import math
import os
import subprocess
import sys
import tempfile

import mitsuba
import numpy
import OpenEXR
from scipy import stats

mitsuba.set_variant("scalar_rgb")

SIZE = 40, 30
RUNS = 6
SAMPLES = 256
DEPTH = 6
EYE, TARGET, FOV_Y_DEGREES = (0.0, 1.0, 3.9), (0.0, 0.9, 0.0), 40.0
WHITE = (1.0, 1.0, 1.0)


def quad(center, u, v):
    center, u, v = (numpy.array(x, dtype=float) for x in (center, u, v))
    return numpy.array([center - u - v, center + u - v, center + u + v, center - u + v]), [[0, 1, 2], [0, 2, 3]]


def sphere(center, radius, rings=24):
    points = [(0.0, 1.0, 0.0)]
    for ring in range(1, rings):
        polar = math.pi * ring / rings
        for step in range(2 * rings):
            azimuth = math.pi * step / rings
            sine = math.sin(polar)
            points.append((sine * math.cos(azimuth), math.cos(polar), -sine * math.sin(azimuth)))
    points.append((0.0, -1.0, 0.0))
    last, around, faces = len(points) - 1, 2 * rings, []
    for step in range(around):
        after = (step + 1) % around
        faces.append([0, 1 + step, 1 + after])
        for ring in range(rings - 2):
            a, b = 1 + ring * around + step, 1 + ring * around + after
            faces += [[a, a + around, b], [b, a + around, b + around]]
        base = 1 + (rings - 2) * around
        faces.append([base + step, last, base + after])
    return numpy.array(points) * radius + numpy.array(center), faces


def material(kind, color=WHITE, alpha=0.0, emission=0.0):
    return {"kind": kind, "color": color, "alpha": alpha, "emission": emission}


GREY, RED, GREEN = (material("diffuse", c) for c in ((0.7, 0.7, 0.7), (0.6, 0.1, 0.1), (0.1, 0.5, 0.1)))
# The index of the glass around it: reflects nothing at its surface, as in Mitsuba.
RED_IN_GLASS = RED | {"ior": 1.5}
BLACK = (0.0, 0.0, 0.0)


def lamp(radiance):
    return material("diffuse", BLACK, emission=radiance)


def box():
    return [
        (quad((0, 0, 0), (0, 0, 1.2), (1.2, 0, 0)), GREY), (quad((0, 2, 0), (1.2, 0, 0), (0, 0, 1.2)), GREY),
        (quad((0, 1, -1.2), (1.2, 0, 0), (0, 1, 0)), GREY), (quad((-1.2, 1, 0), (0, 1, 0), (0, 0, 1.2)), RED),
        (quad((1.2, 1, 0), (0, 0, 1.2), (0, 1, 0)), GREEN),
    ]


def closed_space():
    """Walls around the ball and the camera, open at a window in the wall of -X."""
    wall = [((-1.2, 0.35, 1.5), (0, 0.35, 0), (0, 0, 2.7)), ((-1.2, 1.75, 1.5), (0, 0.25, 0), (0, 0, 2.7)),
            ((-1.2, 1.1, -0.85), (0, 0.4, 0), (0, 0, 0.35)), ((-1.2, 1.1, 2.35), (0, 0.4, 0), (0, 0, 1.85))]
    return [
        (quad((0, 0, 1.5), (0, 0, 2.7), (1.2, 0, 0)), GREY), (quad((0, 2, 1.5), (1.2, 0, 0), (0, 0, 2.7)), GREY),
        (quad((0, 1, -1.2), (1.2, 0, 0), (0, 1, 0)), GREY), (quad((0, 1, 4.2), (0, 1, 0), (1.2, 0, 0)), GREY),
        (quad((1.2, 1, 1.5), (0, 0, 2.7), (0, 1, 0)), GREEN), *((quad(*part), RED) for part in wall),
    ]


CEILING = (quad((0, 1.98, 0), (0.35, 0, 0), (0, 0, 0.35)), lamp(12.0))
FLOOR = (quad((0, 0, 0), (0, 0, 3), (3, 0, 0)), GREY)


def many_lamps():
    random = numpy.random.default_rng(7)
    return [(sphere(random.uniform((-1.1, 0.2, -1.1), (1.1, 1.9, 0.6)), random.uniform(0.01, 0.05), rings=3),
             lamp(float(random.uniform(1, 30)))) for _ in range(100)]


def with_ball(ball, *others):
    return [*others, (sphere((0.0, 0.6, 0.0), 0.55), ball)]


GLASS = material("dielectric")
SCENES = {
    "diffuse_box": {"objects": [*with_ball(GREY, *box()), CEILING]},
    "sky_on_diffuse": {"objects": with_ball(GREY, FLOOR), "sky": "image"},
    "uniform_light": {"objects": with_ball(RED, FLOOR), "sky": "uniform"},
    "point_light": {"objects": with_ball(GREY, *box()), "point": ((0.3, 1.6, 0.5), 3.0)},
    "many_lamps": {"objects": [*with_ball(GREY, *box()), *many_lamps()]},
    "mirror": {"objects": [*with_ball(material("conductor"), *box()), CEILING]},
    "brushed_metal": {"objects": [*with_ball(material("conductor", alpha=0.04), *box()), CEILING]},
    "metal_in_sky": {"objects": with_ball(material("conductor", alpha=0.02), FLOOR), "sky": "image"},
    "glass": {"objects": with_ball(GLASS, *box()), "sky": "uniform"},
    "glass_in_sky": {"objects": with_ball(GLASS, FLOOR), "sky": "image"},
    "frosted_glass": {"objects": with_ball(material("dielectric", alpha=0.01), FLOOR), "sky": "uniform"},
    "ball_in_glass": {"objects": [*with_ball(GLASS, *box(), (sphere((0.0, 0.6, 0.0), 0.25), RED_IN_GLASS)), CEILING]},
    "window": {"objects": with_ball(GREY, *closed_space()), "sky": "image"},
    "glass_by_window": {"objects": with_ball(GLASS, *closed_space()), "sky": "image"},
    "metal_by_window": {"objects": with_ball(material("conductor", alpha=0.04), *closed_space()), "sky": "uniform"},
}


def write_gltf(scene, folder):
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
        "accessors": [], "bufferViews": [], "extensionsUsed": [
            "KHR_materials_ior", "KHR_materials_emissive_strength", "KHR_materials_transmission",
            "KHR_materials_volume", "KHR_lights_punctual"],
    }
    data = b""

    def accessor(array, component, kind):
        nonlocal data
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        data += array.tobytes()
        entry = {"bufferView": len(document["bufferViews"]) - 1, "componentType": component, "type": kind,
                 "count": len(array) if kind != "SCALAR" else array.size}
        if kind == "VEC3":
            entry |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        document["accessors"].append(entry)
        return len(document["accessors"]) - 1

    for (points, faces), of in scene["objects"]:
        is_glass, is_metal = of["kind"] == "dielectric", of["kind"] == "conductor"
        entry = {
            "pbrMetallicRoughness": {"baseColorFactor": [*of["color"], 1.0], "metallicFactor": float(is_metal),
                                     "roughnessFactor": math.sqrt(of["alpha"]) if is_glass or is_metal else 1.0},
            "extensions": {"KHR_materials_ior": {"ior": of.get("ior", 1.5 if is_glass else 1.0)}},
            "doubleSided": of["emission"] == 0.0,
        }
        if is_glass:
            entry["extensions"] |= {"KHR_materials_transmission": {"transmissionFactor": 1.0},
                                    "KHR_materials_volume": {"thicknessFactor": 1.0}}
        if of["emission"]:
            entry["emissiveFactor"] = [1.0, 1.0, 1.0]
            entry["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": of["emission"]}
        document["materials"].append(entry)
        attributes = {"POSITION": accessor(points.astype(numpy.float32), 5126, "VEC3")}
        indices = accessor(numpy.array(faces, dtype=numpy.uint32).ravel(), 5125, "SCALAR")
        material_index = len(document["materials"]) - 1
        document["meshes"].append({"primitives": [
            {"attributes": attributes, "indices": indices, "material": material_index}]})
        document["nodes"].append({"mesh": len(document["meshes"]) - 1})
    if "point" in scene:
        position, intensity = scene["point"]
        document["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": intensity}]}}
        document["nodes"].append({"translation": position, "extensions": {"KHR_lights_punctual": {"light": 0}}})
    document["scenes"][0]["nodes"] = list(range(len(document["nodes"])))
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    document["buffers"] = [{"byteLength": len(data), "uri": uri}]
    path = os.path.join(folder, "scene.gltf")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file)
    return path


def write_sky(folder):
    """A gradient with a warm, soft sun."""
    height, width = 512, 1024
    v, u = numpy.meshgrid((numpy.arange(height) + 0.5) / height, (numpy.arange(width) + 0.5) / width, indexing="ij")
    sky = numpy.stack([0.3 + 0.2 * v, 0.4 + 0.1 * v, 0.9 - 0.4 * v], axis=-1)
    sun = numpy.exp(-((u - 0.7) ** 2 + (0.5 * (v - 0.25)) ** 2) / 0.0008)
    image = (sky + sun[..., None] * numpy.array([40.0, 32.0, 20.0])).astype(numpy.float32)
    path = os.path.join(folder, "sky.exr")
    mitsuba.Bitmap(image).write(path)
    return path


def mitsuba_bsdf(of):
    if of["kind"] == "diffuse":
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(of["color"])}}}
    rough = {"distribution": "ggx", "alpha": of["alpha"]} if of["alpha"] else {}
    if of["kind"] == "conductor":
        bsdf = {"type": "roughconductor" if rough else "conductor", "material": "none", **rough}
        return {"type": "twosided", "bsdf": bsdf}
    return {"type": "roughdielectric" if rough else "dielectric", "int_ior": 1.5, "ext_ior": 1.0, **rough}


def mitsuba_scene(scene, sky):
    transform = mitsuba.ScalarTransform4f
    document = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": DEPTH + 2},
        "sensor": {
            "type": "perspective", "fov": FOV_Y_DEGREES, "fov_axis": "y",
            "to_world": transform().look_at(origin=EYE, target=TARGET, up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": SAMPLES},
        },
    }
    for index, ((points, faces), of) in enumerate(scene["objects"]):
        mesh = mitsuba.Mesh(f"mesh{index}", len(points), len(faces))
        parameters = mitsuba.traverse(mesh)
        parameters["vertex_positions"] = points.astype(numpy.float32).ravel()
        parameters["faces"] = numpy.array(faces, dtype=numpy.uint32).ravel()
        parameters.update()
        path = os.path.join(os.path.dirname(sky), f"mesh{index}.ply")
        mesh.write_ply(path)
        shape = {"type": "ply", "filename": path, "face_normals": True, "bsdf": mitsuba_bsdf(of)}
        if of["emission"]:
            shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": [of["emission"]] * 3}}
        document[f"shape{index}"] = shape
    if scene.get("sky") == "uniform":
        document["sky"] = {"type": "constant", "radiance": {"type": "rgb", "value": [1.0] * 3}}
    elif scene.get("sky") == "image":
        # Mitsuba's image begins where Rayframe's has its centre.
        turned = transform().rotate([0, 1, 0], 180)
        document["sky"] = {"type": "envmap", "filename": sky, "to_world": turned}
    if "point" in scene:
        position, intensity = scene["point"]
        document["lamp"] = {"type": "point", "position": list(position),
                            "intensity": {"type": "rgb", "value": [intensity] * 3}}
    return mitsuba.load_dict(document)


def render_rayframe(program, scene, path, sky, folder):
    images = []
    light = {None: "none", "uniform": "#ffffff", "image": sky}[scene.get("sky")]
    light = os.path.join(folder, "white.exr") if light == "#ffffff" else light
    for seed in range(RUNS):
        output = os.path.join(folder, "frame.exr")
        command = [program, "render", path, "-o", output, "--integrator=path", f"--seed={seed}", "--overwrite", "-q",
                   f"--samples={SAMPLES}", f"--depth={DEPTH}", "-r", f"{SIZE[0]}x{SIZE[1]}", "--exr=float",
                   f"--env={light}", f"--fov={FOV_Y_DEGREES}", "--camera-position", ",".join(map(str, EYE)),
                   "--look-at", ",".join(map(str, TARGET))]
        subprocess.run(command, check=True)
        channels = OpenEXR.File(output, separate_channels=True).channels()
        images.append(numpy.stack([channels[name].pixels for name in "RGB"], axis=-1))
    return numpy.array(images, dtype=numpy.float64)


def render_mitsuba(scene, sky):
    loaded = mitsuba_scene(scene, sky)
    images = [numpy.array(mitsuba.render(loaded, seed=seed + 1, spp=SAMPLES)) for seed in range(RUNS)]
    return numpy.array(images, dtype=numpy.float64)[..., :3]


def main():
    program, names = sys.argv[1], sys.argv[2:] or list(SCENES)
    failed = 0
    print(f"{'scene':16} {'mean':>8} {'mean of Mitsuba':>16} {'least p':>10} {'threshold':>10}  verdict")
    for name in names:
        scene = SCENES[name]
        with tempfile.TemporaryDirectory() as folder:
            sky = write_sky(folder)
            mitsuba.Bitmap(numpy.ones((2, 4, 3), dtype=numpy.float32)).write(os.path.join(folder, "white.exr"))
            path = write_gltf(scene, folder)
            ours = render_rayframe(program, scene, path, sky, folder).mean(axis=-1)
            theirs = render_mitsuba(scene, sky).mean(axis=-1)
        if os.environ.get("KEEP"):
            numpy.savez(os.path.join(os.environ["KEEP"], name), ours=ours, theirs=theirs)
        with numpy.errstate(divide="ignore", invalid="ignore"):
            p = stats.ttest_ind(ours, theirs, axis=0, equal_var=False).pvalue
        # Without any variance both are exact; rounding alone makes them differ.
        equal = numpy.isclose(ours.mean(axis=0), theirs.mean(axis=0), rtol=1e-4)
        p = numpy.where(equal | numpy.isnan(p), 1.0, p)
        threshold = 1.0 - (1.0 - 0.01) ** (1.0 / p.size)
        passes = p.min() >= threshold
        failed += not passes
        print(f"{name:16} {ours.mean():8.5f} {theirs.mean():16.5f} {p.min():10.2e} {threshold:10.2e}  "
              f"{'agrees' if passes else f'{int((p < threshold).sum())} pixels differ'}", flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
