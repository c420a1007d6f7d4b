"""Changes of glTF assets: functions that edit a gltf_asset.Asset in memory, or that make such functions."""

import io
import json

import numpy
from PIL import Image


# Materials.

def pbr(material, **values):
    def change(asset):
        asset.material(material).setdefault("pbrMetallicRoughness", {}).update(values)
    return change


def material(name, **values):
    def change(asset):
        asset.material(name).update(values)
    return change


def extension(name, extension_name, **values):
    def change(asset):
        asset.material(name)["extensions"][extension_name].update(values)
    return change


def base_color(factor, name=0):
    """Multiplies the base colour by a factor, or by one for each channel."""
    def change(asset):
        settings = asset.material(name)["pbrMetallicRoughness"]
        color = numpy.array(settings.get("baseColorFactor", [1, 1, 1, 1]), float)
        color[:3] *= factor
        settings["baseColorFactor"] = color.tolist()
    return change


def without(name, key):
    def change(asset):
        del asset.material(name)[key]
    return change


# Textures.

def texture(index, change_image, kind="PNG", **options):
    def change(asset):
        asset.set_image(index, change_image(asset.image(index)), kind, **options)
    return change


def resized(divisor):
    return lambda image: image.convert("RGB").resize([side // divisor for side in image.size], Image.BOX)


def channels(order):
    return lambda image: Image.merge("RGB", [image.convert("RGB").getchannel(channel) for channel in order])


def values(function):
    def change_image(image):
        pixels = numpy.asarray(image.convert("RGB")).astype(int)
        return Image.fromarray(numpy.clip(function(pixels), 0, 255).astype(numpy.uint8))
    return change_image


def swap_textures(asset):
    first, third = (asset.json["materials"][i]["pbrMetallicRoughness"]["baseColorTexture"] for i in (0, 2))
    first["index"], third["index"] = third["index"], first["index"]


# Vertices.

def vertices(attribute, function):
    """Replaces an attribute of all primitives by a function of its values as floats."""
    def change(asset):
        for accessor in asset.accessors_of(attribute):
            asset.set_array(accessor, function(asset.array(accessor).astype(float)).astype(numpy.float32))
    return change


def quantized(bits):
    def function(positions):
        low, extent = positions.min(axis=0), numpy.ptp(positions, axis=0).max()
        steps = 2 ** bits - 1
        return numpy.round((positions - low) / extent * steps) / steps * extent + low
    return vertices("POSITION", function)


def noise(share):
    """The same offset at equal positions, so that no seam opens."""
    def function(positions):
        unique, inverse = numpy.unique(positions, axis=0, return_inverse=True)
        extent = numpy.ptp(positions, axis=0).max()
        return positions + numpy.random.default_rng(1).uniform(-share, share, unique.shape)[inverse.reshape(-1)] * extent
    return vertices("POSITION", function)


def rounded_normals(steps):
    def function(normals):
        normals = numpy.round(normals * steps) / steps
        return normals / numpy.linalg.norm(normals, axis=1, keepdims=True)
    return vertices("NORMAL", function)


def reverse_winding(asset):
    for primitive in asset.primitives():
        triangles = asset.array(primitive["indices"]).reshape(-1, 3)[:, ::-1]
        asset.set_array(primitive["indices"], triangles.reshape(-1, 1))


def drop_normals(asset):
    for primitive in asset.primitives():
        primitive["attributes"].pop("NORMAL")
        primitive["attributes"].pop("TANGENT", None)


def flatten_normals(asset):
    """Vertices of their own for each triangle, with its normal."""
    for primitive in asset.primitives():
        corners = asset.array(primitive.pop("indices"))[:, 0]
        for accessor in primitive["attributes"].values():
            asset.set_array(accessor, asset.array(accessor)[corners])
        triangles = asset.array(primitive["attributes"]["POSITION"]).reshape(-1, 3, 3)
        normals = numpy.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normals /= numpy.maximum(numpy.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        asset.set_array(primitive["attributes"]["NORMAL"], normals.repeat(3, axis=0).astype(numpy.float32))


# Meshes, joints, clips, lights and cameras.

def node(name, **values):
    def change(asset):
        asset.node(name).update(values)
    return change


def bounds_extent(asset):
    """The largest extent of the scene's largest mesh, in its own units."""
    extents = [numpy.ptp(asset.array(accessor), axis=0).max() for accessor in asset.accessors_of("POSITION")]
    return float(max(extents))


def move(name, share, axis=0):
    def change(asset):
        target = asset.node(name)
        translation = list(target.get("translation", [0.0, 0.0, 0.0]))
        translation[axis] += share * bounds_extent(asset)
        target["translation"] = translation
    return change


def scale(name, factor):
    def change(asset):
        target = asset.node(name)
        target["scale"] = [factor * value for value in target.get("scale", [1, 1, 1])]
    return change


def remove(name):
    def change(asset):
        del asset.node(name)["mesh"]
    return change


def recolor_one(name, color):
    def change(asset):
        asset.material(name)["pbrMetallicRoughness"]["baseColorFactor"] = color
    return change


def multiply_quaternions(a, b):
    (ax, ay, az, aw), (bx, by, bz, bw) = a.T, b
    return numpy.stack([aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
                        aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz], axis=1)


def rotate_joint(joint, degrees):
    """Rotates a joint about its own z axis, in its pose and in all clips."""
    def change(asset):
        index = asset.of("nodes", joint)
        half = numpy.radians(degrees) / 2
        turn = numpy.array([0, 0, numpy.sin(half), numpy.cos(half)])
        rotation = numpy.array([asset.json["nodes"][index].get("rotation", [0, 0, 0, 1])], float)
        asset.json["nodes"][index]["rotation"] = multiply_quaternions(rotation, turn)[0].tolist()
        for clip in asset.json["animations"]:
            for channel in clip["channels"]:
                if channel["target"].get("node") == index and channel["target"]["path"] == "rotation":
                    output = clip["samplers"][channel["sampler"]]["output"]
                    keys = asset.array(output).astype(float)
                    asset.set_array(output, multiply_quaternions(keys, turn).astype(numpy.float32))
    return change


def wrong_weights(joint):
    """Vertices that follow one joint follow the skeleton's root instead."""
    def change(asset):
        index = asset.json["skins"][0]["joints"].index(asset.of("nodes", joint))
        for accessor in asset.accessors_of("JOINTS_0"):
            joints = asset.array(accessor)
            joints[joints == index] = 0
            asset.set_array(accessor, joints)
    return change


def delete_clips(asset):
    del asset.json["animations"]


def key_times(function):
    def change(asset):
        inputs = {sampler["input"] for clip in asset.json["animations"] for sampler in clip["samplers"]}
        for accessor in inputs:
            asset.set_array(accessor, function(asset.array(accessor).astype(float)).astype(numpy.float32))
    return change


def interpolation(kind):
    def change(asset):
        for sampler in asset.json["animations"][0]["samplers"]:
            if sampler.get("interpolation", "LINEAR") == "LINEAR":
                sampler["interpolation"] = kind
    return change


def light(index, **values):
    def change(asset):
        asset.json["extensions"]["KHR_lights_punctual"]["lights"][index].update(values)
    return change


def dimmed(index, factor):
    def change(asset):
        found = asset.json["extensions"]["KHR_lights_punctual"]["lights"][index]
        found["intensity"] = factor * found.get("intensity", 1.0)
    return change


def remove_light(index):
    def change(asset):
        for item in asset.json["nodes"]:
            if item.get("extensions", {}).get("KHR_lights_punctual", {}).get("light") == index:
                del item["extensions"]["KHR_lights_punctual"]
    return change


def move_camera(share):
    def change(asset):
        target = next(item for item in asset.json["nodes"] if "camera" in item)
        if "matrix" in target:
            target["matrix"][12] += share * bounds_extent(asset)
        else:
            translation = list(target.get("translation", [0.0, 0.0, 0.0]))
            target["translation"] = [translation[0] + share * bounds_extent(asset), *translation[1:]]
    return change


def field_of_view(factor):
    def change(asset):
        asset.json["cameras"][0]["perspective"]["yfov"] *= factor
    return change


# Lossless re-encodings.

def same(asset):
    """Only the encoding of the file changes."""


def recompress_images(asset):
    for index in range(len(asset.images)):
        if asset.images[index][0] == "image/png":
            stream = io.BytesIO()
            asset.image(index).save(stream, "PNG", compress_level=1)
            asset.images[index] = ("image/png", stream.getvalue())


def renumber(kind, uses):
    """Reverses a list of the JSON; `uses` lists the dictionaries and keys that hold its indices."""
    def change(asset):
        count = len(asset.json[kind])
        asset.json[kind].reverse()
        for holder, key in uses(asset.json):
            old = holder[key]
            holder[key] = [count - 1 - index for index in old] if isinstance(old, list) else count - 1 - old
    return change


def uses_of_nodes(content):
    for scene in content["scenes"]:
        yield scene, "nodes"
    for item in content["nodes"]:
        if "children" in item:
            yield item, "children"


def uses_in_primitives(content):
    for mesh in content["meshes"]:
        for primitive in mesh["primitives"]:
            if "material" in primitive:
                yield primitive, "material"


def uses_of_meshes(content):
    for item in content["nodes"]:
        if "mesh" in item:
            yield item, "mesh"


def shuffle_triangles(asset):
    for primitive in asset.primitives():
        triangles = asset.array(primitive["indices"]).reshape(-1, 3)
        numpy.random.default_rng(1).shuffle(triangles)
        asset.set_array(primitive["indices"], triangles.reshape(-1, 1))


def rotate_triangles(asset):
    for primitive in asset.primitives():
        triangles = numpy.roll(asset.array(primitive["indices"]).reshape(-1, 3), 1, axis=1)
        asset.set_array(primitive["indices"], triangles.reshape(-1, 1))


def shuffle_vertices(asset):
    for primitive in asset.primitives():
        count = asset.json["accessors"][primitive["attributes"]["POSITION"]]["count"]
        order = numpy.random.default_rng(1).permutation(count)
        for accessor in primitive["attributes"].values():
            asset.set_array(accessor, asset.array(accessor)[order])
        indices = asset.array(primitive["indices"])
        asset.set_array(primitive["indices"], numpy.argsort(order)[indices].astype(numpy.uint32))


def wide_indices(asset):
    for primitive in asset.primitives():
        asset.set_array(primitive["indices"], asset.array(primitive["indices"]).astype(numpy.uint32))


def add_unused(asset):
    """A material and a mesh that nothing uses, before all others, as a pruning tool removes them."""
    asset.json["materials"].insert(0, {"name": "unused"})
    for holder, key in uses_in_primitives(asset.json):
        holder[key] += 1
    asset.json["meshes"].insert(0, json.loads(json.dumps(asset.json["meshes"][0])))
    for holder, key in uses_of_meshes(asset.json):
        holder[key] += 1


def rename(asset):
    for kind in ("nodes", "meshes", "materials", "animations", "images", "cameras", "skins"):
        for index, item in enumerate(asset.json.get(kind, [])):
            item["name"] = f"renamed {kind} {index}"


def write_defaults(asset):
    for item in asset.json["materials"]:
        item.setdefault("alphaMode", "OPAQUE")
        item.setdefault("doubleSided", False)
        item.setdefault("emissiveFactor", [0, 0, 0])
        settings = item.setdefault("pbrMetallicRoughness", {})
        for key, value in (("baseColorFactor", [1, 1, 1, 1]), ("metallicFactor", 1), ("roughnessFactor", 1)):
            settings.setdefault(key, value)
