#!/usr/bin/env python3
"""Reads layers, attributes and Cryptomattes of EXR files with the OpenEXR Python module and with OpenImageIO.

Needs the PyPI packages `OpenEXR`, `OpenImageIO` and `numpy`; not part of the default tests.
Run from the project's root after `cargo build --release`: python3 tests/oracles/read_layers.py [PROGRAM] [SCENE]

Checked are, for every compression and type: the names and types of all channels, that both readers see the same numbers, that what
loses nothing holds the same numbers as ZIP, and all attributes. The mattes of a frame are decoded from the manifest alone and compared with
the alpha of each node rendered by itself; PROGRAM defaults to target/release/rayframe.
"""

import json
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy
import OpenEXR

try:
    import OpenImageIO
except ImportError:
    OpenImageIO = None

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "target/release/rayframe"
SCENE = sys.argv[2] if len(sys.argv) > 2 else "scenes/demo/whitted_1980.gltf"
SIZE = ["-r", "96x54", "-f", "2", "--samples", "16", "-q", "--overwrite"]
LIGHT = ["emission", "direct", "environment", "reflection", "refraction", "pass_through"]
COMPRESSIONS = ["none", "rle", "zips", "zip", "piz", "dwaa", "dwab"]


def render(folder, name, *options, scene=None):
    path = pathlib.Path(folder) / name
    subprocess.run([PROGRAM, "render", str(scene or SCENE), "-o", str(path), *SIZE, *options], check=True)
    return path


def channels(path):
    """Names to arrays, each channel by itself."""
    part = OpenEXR.File(str(path), separate_channels=True).parts[0]
    return {name: channel.pixels for name, channel in part.channels.items()}


def expected_types(light):
    types = {name: light for name in "RGBA"}
    types |= {f"{part}.{c}": light for part in LIGHT for c in "RGB"}
    types |= {f"{layer}.{c}": "float32" for layer in ["position", "normal", "geometric_normal"] for c in "XYZ"}
    types |= {f"albedo.{c}": "float32" for c in "RGB"}
    types |= {f"{way}.{c}": "float32" for way in ["forward", "backward"] for c in "uv"}
    types |= {name: "float32" for name in ["Z", "uv.U", "uv.V"]}
    types |= {name: "uint32" for name in ["object_id", "material_id", "node_id"]}
    mattes = ["crypto_object", "crypto_material"]
    types |= {f"{layer}{i:02}.{c}": "float32" for layer in mattes for i in range(3) for c in "RGBA"}
    return types


def check_channels(path, light, layers=None):
    found = {name: str(pixels.dtype) for name, pixels in channels(path).items()}
    expected = expected_types(light)
    if layers is not None:
        expected = {name: kind for name, kind in expected.items() if name in layers}
    assert found == expected, (path, found, expected)


def check_with_openimageio(path):
    """The same names and numbers through the other reader."""
    if OpenImageIO is None:
        return
    file = OpenImageIO.ImageInput.open(str(path))
    spec = file.spec()
    by_openexr = channels(path)
    assert set(spec.channelnames) == set(by_openexr), (spec.channelnames, list(by_openexr))
    for index, name in enumerate(spec.channelnames):
        kind = OpenImageIO.UINT if by_openexr[name].dtype == numpy.uint32 else OpenImageIO.FLOAT
        pixels = file.read_image(0, 0, index, index + 1, kind)
        assert pixels is not None, (name, file.geterror())
        same = numpy.array_equal(numpy.asarray(pixels)[..., 0], by_openexr[name].astype(numpy.asarray(pixels).dtype))
        assert same, (path, name)
    rate = spec.getattribute("FramesPerSecond") or spec.getattribute("framesPerSecond")
    assert rate is not None and tuple(rate) == (24, 1), rate
    assert spec.getattribute("frame") == 2
    file.close()


def check_attributes(path):
    header = OpenEXR.File(str(path)).header()
    assert header["framesPerSecond"] == 24, header["framesPerSecond"]
    code = header["timeCode"]
    assert (code.hours, code.minutes, code.seconds, code.frame) == (0, 0, 0, 2), code
    chromaticities = header["chromaticities"]
    expected = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
    assert numpy.allclose(tuple(chromaticities), expected, atol=1e-6), chromaticities
    for name in ["worldToCamera", "worldToNDC"]:
        assert numpy.asarray(header[name]).shape == (4, 4), name
    assert header["frame"] == 2 and abs(header["timeSeconds"] - 2 / 24) < 1e-12
    assert len(header["renderHash"]) == 64 and header["software"].startswith("rayframe ")
    for name in ["capDate", "renderSeconds", "hostComputer"]:
        assert name not in header, name
    return header


def check_projection(path, header):
    """`worldToNDC` takes the position of each pixel's middle back to that pixel."""
    layers = channels(path)
    hit = layers["node_id"] > 0
    rows, columns = numpy.nonzero(hit)
    ones = numpy.ones(len(rows))
    points = numpy.stack([layers[f"position.{c}"][hit] for c in "XYZ"] + [ones], axis=1)
    ndc = points @ numpy.asarray(header["worldToNDC"], dtype=float)
    height, width = hit.shape
    x, y = ndc[:, 0] / ndc[:, 3] * width, ndc[:, 1] / ndc[:, 3] * height
    worst = max(abs(x - columns - 0.5).max(), abs(y - rows - 0.5).max())
    assert worst < 0.01, f"positions lie {worst} pixels beside their pixels"
    camera = points @ numpy.asarray(header["worldToCamera"], dtype=float)
    assert numpy.allclose(-camera[:, 2], layers["Z"][hit], rtol=1e-4, atol=1e-4)


def check_sum(path):
    """The light passes sum to the colour, within two steps of a half for each."""
    layers = channels(path)
    for c in "RGB":
        total = sum(layers[f"{part}.{c}"].astype(float) for part in LIGHT)
        beauty = layers[c].astype(float)
        steps = numpy.abs(total - beauty) / numpy.maximum(numpy.abs(beauty), 2.0**-14)
        assert (steps < 8 * 2.0**-11).all(), (c, steps.max())


def murmur3(data):
    """MurmurHash3_x86_32 with seed 0."""
    mask, c1, c2, value = 0xFFFFFFFF, 0xCC9E2D51, 0x1B873593, 0
    turn = lambda x, n: ((x << n) | (x >> (32 - n))) & mask
    whole = len(data) // 4 * 4
    for at in range(0, whole, 4):
        value ^= turn(int.from_bytes(data[at : at + 4], "little") * c1 & mask, 15) * c2 & mask
        value = (turn(value, 13) * 5 + 0xE6546B64) & mask
    if data[whole:]:
        value ^= turn(int.from_bytes(data[whole:], "little") * c1 & mask, 15) * c2 & mask
    value ^= len(data)
    value = (value ^ value >> 16) * 0x85EBCA6B & mask
    value = (value ^ value >> 13) * 0xC2B2AE35 & mask
    return value ^ value >> 16


def mattes(path, wanted):
    """Coverage by name, from nothing but the file."""
    header = OpenEXR.File(str(path)).header()
    pixels = channels(path)
    for key in [key for key in header if key.startswith("cryptomatte/") and key.endswith("/name")]:
        if header[key] != wanted:
            continue
        prefix = key[: -len("name")]
        assert prefix == f"cryptomatte/{murmur3(wanted.encode()):08x}"[:19] + "/", prefix
        assert header[prefix + "hash"] == "MurmurHash3_32"
        assert header[prefix + "conversion"] == "uint32_to_float32"
        manifest = json.loads(header[prefix + "manifest"])
        decoded = {}
        for name, digits in manifest.items():
            hashed = murmur3(name.encode())
            if (hashed >> 23 & 255) in (0, 255):
                hashed ^= 1 << 23
            assert f"{hashed:08x}" == digits, name
            value = struct.unpack("<f", bytes.fromhex(digits)[::-1])[0]
            matte = 0.0
            for level in range(3):
                for id_channel, coverage in ["RG", "BA"]:
                    ids = pixels[f"{wanted}{level:02}.{id_channel}"]
                    share = pixels[f"{wanted}{level:02}.{coverage}"]
                    matte = matte + numpy.where(ids == numpy.float32(value), share, 0.0)
            decoded[name] = matte
        return decoded
    raise AssertionError(f"{path} has no Cryptomatte {wanted}")


def alone(scene, node, folder):
    """The scene without the meshes of all other nodes, its buffers beside it."""
    document = json.loads(pathlib.Path(scene).read_text())
    for index, other in enumerate(document["nodes"]):
        if index != node:
            other.pop("mesh", None)
            other.pop("skin", None)
            other.pop("weights", None)
    for clip in document.get("animations", []):
        moves_nothing = lambda target: target["path"] == "weights" and target.get("node") != node
        clip["channels"] = [channel for channel in clip["channels"] if not moves_nothing(channel["target"])]
    for kind in ["buffers", "images"]:
        for item in document.get(kind, []):
            uri = item.get("uri", "")
            if uri and not uri.startswith("data:"):
                (folder / uri).parent.mkdir(parents=True, exist_ok=True)
                (folder / uri).write_bytes((pathlib.Path(scene).parent / uri).read_bytes())
    path = folder / f"alone{node}.gltf"
    path.write_text(json.dumps(document))
    return path


def check_mattes(path, folder):
    """A node's matte is the alpha of that node alone, less what other nodes hide."""
    decoded = mattes(path, "crypto_object")
    alpha = channels(path)["A"].astype(float)
    total = sum(decoded.values())
    assert numpy.abs(total - alpha).max() < 2e-3, f"mattes sum to {numpy.abs(total - alpha).max()} beside alpha"
    document = json.loads(pathlib.Path(SCENE).read_text())
    compared, seen = 0, {}
    for index, node in enumerate(document["nodes"]):
        if "mesh" not in node:
            continue
        own_name = node.get("name") or f"#{index}"
        seen[own_name] = seen.get(own_name, 0) + 1
        name = own_name if seen[own_name] == 1 else f"{own_name} ({seen[own_name]})"
        if name not in decoded:
            continue
        options = ["--background", "none", "--layers", "crypto_object"]
        file = render(folder, f"alone{index}.####.exr", *options, scene=alone(SCENE, index, folder))
        file = pathlib.Path(str(file).replace("####", "0002"))
        own = channels(file)["A"].astype(float)
        assert numpy.abs(mattes(file, "crypto_object")[own_name] - own).max() < 1e-3, name
        assert (decoded[name] <= own + 1e-3).all(), f"{name} covers more than it does alone"
        # Where nothing else covers the pixel the two are the same.
        free = numpy.abs(total - decoded[name]) < 1e-6
        assert numpy.abs(decoded[name] - own)[free].max(initial=0.0) < 1e-3, name
        compared += 1
    assert compared > 0
    return compared


def main():
    folder = pathlib.Path(tempfile.mkdtemp())
    numbered = lambda path: pathlib.Path(str(path).replace("####", "0002"))

    # One file of everything, in every compression that may be.
    exact = None
    for samples, dtype in [("half", "float16"), ("float", "float32")]:
        for compression in COMPRESSIONS[:5]:
            file = numbered(render(folder, f"all_{samples}_{compression}.####.exr", "--layers", "all", "--background", "none", "--exr", f"{samples},{compression}"))
            check_channels(file, dtype)
            check_with_openimageio(file)
            read = channels(file)
            if compression == "none":
                exact = read
            assert all(numpy.array_equal(read[name], exact[name]) for name in exact), (samples, compression)
        check_sum(file)
    header = check_attributes(file)
    check_projection(file, header)

    # Light with loss beside data without.
    for compression in COMPRESSIONS[5:]:
        options = ["--layers", "all", "--background", "none", "--exr", f"float,{compression}", "--split-aovs"]
        main_file = numbered(render(folder, f"split_{compression}.####.exr", *options))
        check_channels(main_file, "float32", "RGBA")
        check_with_openimageio(main_file)
        for name in exact:
            layer = {"Z": "depth", "forward": "motion", "backward": "motion"}.get(name.split(".")[0], name.split(".")[0])
            layer = layer[:-2] if layer.startswith("crypto") else layer
            if name in "RGBA":
                continue
            file = folder / f"split_{compression}.{layer}.0002.exr"
            read = channels(file)[name]
            if layer in LIGHT:
                error = numpy.abs(read.astype(float) - exact[name])
                assert (error <= 0.02 + 0.1 * numpy.abs(exact[name])).mean() > 0.99, (compression, name, error.max())
            else:
                assert numpy.array_equal(read, exact[name]), (compression, name)
            check_with_openimageio(file)

    compared = check_mattes(numbered(folder / "all_half_zip.####.exr"), folder)

    # A stamp is there when asked for.
    header = OpenEXR.File(str(numbered(render(folder, "stamped.####.exr", "--stamp")))).header()
    assert header["renderSeconds"] > 0.0 and header["utcOffset"] == 0.0 and len(header["capDate"]) == 19
    print(f"all layers, attributes and {compared} mattes are read{'' if OpenImageIO else ' (OpenImageIO is missing)'}")


main()
