#!/usr/bin/env python3
"""Compares mirrors and smooth glass with Mitsuba 3 on three scenes of flat faces, Lambertian floors and point lights.

Needs the PyPI packages `mitsuba`, `flip-evaluator`, `OpenEXR` and `numpy`, and LLVM's library for Mitsuba's `llvm` variant; not part
of the default tests. Run from the project's root: python3 tests/oracles/compare_glass.py [FOLDER]

Mitsuba computes hits, Fresnel factors and directions. The integrator below samples specular paths at random and ends at the first
diffuse surface with its direct light. Its expected value is that of Whitted's ray tree. The comparison fails if the means differ by
more than 0.5 % or the mean FLIP is above 0.02. Scenes and images are kept in FOLDER.
"""

import base64
import json
import pathlib
import subprocess
import sys
import tempfile

import flip_evaluator
import mitsuba
import numpy
import OpenEXR

mitsuba.set_variant("llvm_ad_rgb")
import drjit as dr  # noqa: E402  (the variant must be set first)

SIZE = (320, 180)
DEPTH = 24
RAYFRAME_SAMPLES = 256
MITSUBA_SAMPLES = 4096
MEAN_LIMIT = 0.005
FLIP_LIMIT = 0.02


class Tree(mitsuba.SamplingIntegrator):
    """Specular paths to the first diffuse surface, lit by point lights."""

    @dr.syntax
    def sample(self, scene, sampler, ray, medium=None, active=True):
        context = mitsuba.BSDFContext()
        ray = mitsuba.Ray3f(ray)
        active = mitsuba.Bool(active)
        radiance = mitsuba.Color3f(0.0)
        throughput = mitsuba.Color3f(1.0)
        depth = mitsuba.UInt32(0)
        while active:
            hit = scene.ray_intersect(ray, active)
            active &= hit.is_valid()
            bsdf = hit.bsdf(ray)
            diffuse = active & mitsuba.has_flag(bsdf.flags(), mitsuba.BSDFFlags.Smooth)
            towards, arriving = scene.sample_emitter_direction(hit, sampler.next_2d(diffuse), True, diffuse)
            scattered = bsdf.eval(context, hit, hit.to_local(towards.d), diffuse)
            radiance[diffuse] += throughput * scattered * arriving
            active &= ~diffuse & (depth < DEPTH)
            chosen, share = bsdf.sample(context, hit, sampler.next_1d(active), sampler.next_2d(active), active)
            ray = hit.spawn_ray(hit.to_world(chosen.wo))
            throughput *= share
            depth += 1
        return radiance, mitsuba.Bool(True), []


def rectangle(center, u, v):
    """Vertices and triangles of a rectangle with the half edges u and v. Its front faces u × v."""
    center, u, v = map(numpy.array, (center, u, v))
    corners = [center - u - v, center + u - v, center + u + v, center - u + v]
    return numpy.array(corners, dtype="f4"), numpy.array([[0, 1, 2], [0, 2, 3]], dtype="u4")


def joined(parts):
    positions, triangles, count = [], [], 0
    for corners, faces in parts:
        positions.append(corners)
        triangles.append(faces + count)
        count += len(corners)
    return numpy.concatenate(positions), numpy.concatenate(triangles).astype("u4")


def box(center, half, angle=0.0):
    """A closed box with outward faces, rotated about y."""
    c, s = numpy.cos(angle), numpy.sin(angle)
    axes = numpy.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) * numpy.array(half)[:, None]
    faces = []
    for axis in range(3):
        for sign in (-1, 1):
            u, v = axes[(axis + 1) % 3], axes[(axis + 2) % 3] * sign
            faces.append(rectangle(numpy.array(center) + sign * axes[axis], u, v))
    return joined(faces)


def prism(center, size):
    """A right-angled prism. Its longest face points away from the camera."""
    a, b, c = ([-size, -size], [size, -size], [-size, size])
    at = lambda p, z: numpy.array(center) + numpy.array([p[0], p[1], z])
    corners = numpy.array([at(p, z) for z in (-size, size) for p in (a, b, c)], dtype="f4")
    sides = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]
    return corners, numpy.array(sides, dtype="u4")


def floor():
    squares = {"light": [], "dark": []}
    for i in range(-6, 6):
        for j in range(-8, 4):
            center = [i + 0.5, 0, j + 0.5]
            squares["light" if (i + j) % 2 else "dark"].append(rectangle(center, [0, 0, 0.5], [0.5, 0, 0]))
    return [(joined(squares["light"]), ("diffuse", [0.8, 0.75, 0.6])), (joined(squares["dark"]), ("diffuse", [0.1, 0.15, 0.3]))]


def scenes():
    """Name, parts (mesh, material), lights (position, intensity), and camera position. It looks along −Z, field of view 40°."""
    wall = (rectangle([0, 3, -6], [6, 0, 0], [0, 3, 0]), ("diffuse", [0.5, 0.25, 0.2]))
    lights = [([2.0, 4.0, 2.0], [60, 55, 50]), ([-3.0, 3.0, 1.0], [10, 15, 25])]
    glass = ("glass", 1.5, 1.0)
    yield "boxes", floor() + [wall, (box([-0.9, 0.81, -1.0], [0.5, 0.8, 0.5], 0.4), glass),
                              (box([0.9, 0.61, -0.6], [0.6, 0.6, 0.3], -0.5), ("glass", 2.4, 1.0))], lights, [0, 1.2, 4]
    yield "prism", floor() + [wall, (prism([0.3, 0.95, -0.5], 0.7), glass),
                              (rectangle([-2.2, 1.2, -1.5], [0.7, 0, 0.7], [0, 1.1, 0]), ("mirror",)),
                              (rectangle([2.2, 1.2, -1.5], [0.7, 0, -0.7], [0, 1.1, 0]), ("mirror",))], lights, [0, 1.2, 4]
    yield "nested", floor() + [wall, (box([0, 1.01, -0.5], [0.9, 0.9, 0.6], 0.3), glass),
                               (box([-0.3, 1.0, -0.5], [0.3, 0.5, 0.3], 0.3), ("glass", 1.0, 1.5)),
                               (box([0.45, 1.0, -0.55], [0.2, 0.4, 0.2], 0.8), ("glass", 1.8, 1.5))], lights, [0, 1.2, 4]


def gltf_material(material):
    kind = material[0]
    if kind == "mirror":
        return {"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}, "doubleSided": True}
    if kind == "glass":
        extensions = {"KHR_materials_ior": {"ior": material[1]}, "KHR_materials_transmission": {"transmissionFactor": 1},
                      "KHR_materials_volume": {"thicknessFactor": 1}}
        return {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions": extensions}
    # An index of refraction of 1 makes the surface purely Lambertian.
    return {"pbrMetallicRoughness": {"baseColorFactor": material[1] + [1], "metallicFactor": 0}, "doubleSided": True,
            "extensions": {"KHR_materials_ior": {"ior": 1}}}


def write_gltf(path, parts, lights, eye):
    blob, views, accessors, meshes = b"", [], [], []
    for (positions, triangles), _ in parts:
        for array, kind, component in ((positions, "VEC3", 5126), (triangles.reshape(-1), "SCALAR", 5125)):
            array = array.astype("f4" if component == 5126 else "u4")
            views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": array.nbytes})
            accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind})
            if kind == "VEC3":
                accessors[-1].update(min=array.min(0).tolist(), max=array.max(0).tolist())
            blob += array.tobytes()
        primitive = {"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1, "material": len(meshes)}
        meshes.append({"primitives": [primitive]})
    nodes = [{"mesh": i} for i in range(len(meshes))] + [{"camera": 0, "translation": eye}]
    nodes += [{"translation": p, "extensions": {"KHR_lights_punctual": {"light": i}}} for i, (p, _) in enumerate(lights)]
    lights = [{"type": "point", "color": (numpy.array(c) / max(c)).tolist(), "intensity": max(c)} for _, c in lights]
    json.dump({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes,
        "materials": [gltf_material(material) for _, material in parts], "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(blob), "uri": "data:application/octet-stream;base64," + base64.b64encode(blob).decode()}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": float(numpy.radians(40)), "znear": 0.01}}],
        "extensions": {"KHR_lights_punctual": {"lights": lights}},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume"],
    }, open(path, "w"))


def mitsuba_material(material):
    if material[0] == "mirror":
        return {"type": "twosided", "bsdf": {"type": "conductor", "material": "none"}}
    if material[0] == "glass":
        return {"type": "dielectric", "int_ior": material[1], "ext_ior": material[2]}
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": material[1]}}}


def mitsuba_image(parts, lights, eye):
    view = mitsuba.ScalarTransform4f().look_at(origin=eye, target=[eye[0], eye[1], eye[2] - 1], up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    sensor = {"type": "perspective", "fov": 40, "fov_axis": "y", "near_clip": 0.01, "to_world": view, "film": film}
    scene = {"type": "scene", "sensor": sensor}
    for i, (position, intensity) in enumerate(lights):
        scene[f"light{i}"] = {"type": "point", "position": position, "intensity": {"type": "rgb", "value": intensity}}
    for i, ((positions, triangles), material) in enumerate(parts):
        properties = mitsuba.Properties()
        properties["bsdf"] = mitsuba.load_dict(mitsuba_material(material))
        mesh = mitsuba.Mesh(f"part{i}", len(positions), len(triangles), props=properties)
        params = mitsuba.traverse(mesh)
        params["vertex_positions"] = positions.astype("f4").ravel()
        params["faces"] = triangles.ravel()
        params.update()
        scene[f"part{i}"] = mesh
    scene = mitsuba.load_dict(scene)
    total = numpy.zeros((SIZE[1], SIZE[0], 3))
    for seed in range(MITSUBA_SAMPLES // 256):
        total += numpy.array(mitsuba.render(scene, integrator=Tree(mitsuba.Properties()), seed=seed, spp=256))
    return total / (MITSUBA_SAMPLES // 256)


def rayframe_image(scene, output):
    size = f"{SIZE[0]}x{SIZE[1]}"
    options = ["--glass-shadows", "opaque", "--depth", str(DEPTH), "--samples", str(RAYFRAME_SAMPLES), "-r", size, "--overwrite", "-q"]
    subprocess.run(["cargo", "run", "-q", "--release", "--", "render", scene, "-o", output] + options, check=True)
    return OpenEXR.File(str(output)).channels()["RGBA"].pixels[..., :3].astype(float)


def encode_srgb(image):
    image = numpy.clip(image, 0, 1)
    return numpy.where(image <= 0.0031308, 12.92 * image, 1.055 * image ** (1 / 2.4) - 0.055).astype("f4")


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    failed = False
    for name, parts, lights, eye in scenes():
        write_gltf(folder / f"{name}.gltf", parts, lights, eye)
        ours = rayframe_image(folder / f"{name}.gltf", folder / f"{name}.exr")
        theirs = mitsuba_image(parts, lights, eye)
        numpy.save(folder / f"{name}.mitsuba.npy", theirs)
        mean = ours.mean() / theirs.mean() - 1
        flip = flip_evaluator.evaluate(encode_srgb(theirs), encode_srgb(ours), "LDR", inputsRGB=True)[1]
        is_wrong = abs(mean) > MEAN_LIMIT or flip > FLIP_LIMIT
        failed |= is_wrong
        print(f"{name:8} mean {mean:+.4%}  FLIP {flip:.4f}  {'WRONG' if is_wrong else 'ok'}")
    sys.exit(failed)


main()
