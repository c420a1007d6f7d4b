#!/usr/bin/env python3
"""Reads a frame of Rayframe in Blender's compositor, and compares what its nodes give with the file.

usage: read_in_blender.py RAYFRAME    Needs the PyPI packages bpy and OpenImageIO.

Renders the hiker of scenes/showcase with layers. Compares with OpenImageIO's pixels: the colours and depths that the node Image
gives, and the matte of the jacket that the node Cryptomatte makes, with the sum of its ranks. The exit code is 1 where one differs.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import bpy
import numpy
import OpenImageIO as oiio

ROOT = pathlib.Path(__file__).resolve().parents[2]
MATERIAL = "jacket"


def channels(path):
    """The channels of a file by their names, and its attributes."""
    image = oiio.ImageBuf(str(path))
    pixels = image.get_pixels(oiio.FLOAT)
    return {name: pixels[..., index] for index, name in enumerate(image.spec().channelnames)}, image.spec()


def matte_of(planes, spec, layer, name):
    """Coverage by one name: the sum over the ranks of a Cryptomatte that have its hash."""
    keys = [attribute.name.rpartition("/")[0] for attribute in spec.extra_attribs if attribute.name.startswith("cryptomatte/") and attribute.value == layer]
    hashes = json.loads(spec.getattribute(f"{keys[0]}/manifest"))
    identifier = numpy.uint32(int(hashes[name], 16)).view(numpy.float32)
    pairs = [(f"{layer}{rank:02}.{first}", f"{layer}{rank:02}.{second}") for rank in range(3) for first, second in ("RG", "BA")]
    return sum(numpy.where(planes[first] == identifier, planes[second], 0) for first, second in pairs)


def composite(tree, socket, output):
    """Runs the compositor with one socket as its image, and returns the channels that it writes."""
    node = tree.nodes.get("Composite") or tree.nodes.new("CompositorNodeComposite")
    for link in list(node.inputs["Image"].links):
        tree.links.remove(link)
    tree.links.new(socket, node.inputs["Image"])
    bpy.context.scene.render.filepath = str(output)
    bpy.ops.render.render(write_still=True)
    return channels(output)[0]


def prepared_scene(size):
    """Nodes of a scene that renders nothing and writes floats as they are."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        frame = folder / "element.exr"
        command = f"render {ROOT}/scenes/showcase/character.gltf -q --animation walk -f 5 --background none --ground -r 240x135 -o {frame}"
        subprocess.run([sys.argv[1], *command.split(), "--aovs", "depth,normal,motion,crypto"], check=True)
        planes, spec = channels(frame)
        tree = prepared_scene((240, 135))
        image = tree.nodes.new("CompositorNodeImage")
        image.image = bpy.data.images.load(str(frame))
        print(f"Blender {bpy.app.version_string}, sockets: {', '.join(socket.name for socket in image.outputs)}")
        crypto = tree.nodes.new("CompositorNodeCryptomatteV2")
        crypto.source, crypto.image, crypto.layer_name, crypto.matte_id = "IMAGE", image.image, "crypto_material", MATERIAL
        colours = composite(tree, image.outputs["Combined"], folder / "combined.exr")
        depths = composite(tree, image.outputs["Depth"], folder / "depth.exr")
        mattes = composite(tree, crypto.outputs["Matte"], folder / "matte.exr")
    pairs = [(f"colours {channel}", colours[channel], planes[channel]) for channel in "RGBA"]
    pairs.append(("depth", depths["R"], planes["Z"]))
    pairs.append((f"matte {MATERIAL}", mattes["R"], matte_of(planes, spec, "crypto_material", MATERIAL)))
    differences = {what: float(abs(one - other).max()) for what, one, other in pairs}
    for what, one, _ in pairs:
        print(f"{what}: sum {one.sum():.3f}, largest difference {differences[what]:g}")
    sys.exit(any(difference > 1e-6 for difference in differences.values()))


if __name__ == "__main__":
    main()
