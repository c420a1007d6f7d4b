#!/usr/bin/env python3
"""Reads AOVs, attributes and Cryptomattes of EXR files with the OpenEXR Python module and with OpenImageIO.

Needs the PyPI packages `OpenEXR`, `OpenImageIO` and `numpy`; not part of the default tests.
Run from the project's root after `cargo build --release`: python3 tests/oracles/read_aovs.py [PROGRAM] [SCENE]

For every compression and sample type it checks the names and types of all channels, that both readers return the same values, that
lossless compressions hold the same values, and all attributes. It decodes the mattes of a frame from the manifest alone and compares
them with the alpha of each node rendered by itself. PROGRAM defaults to target/release/rayframe.
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
LIGHT_PASSES = ["emission", "direct", "environment", "reflection", "refraction", "pass_through"]
COMPRESSIONS = ["none", "rle", "zips", "zip", "piz", "dwaa", "dwab"]


def render(folder, name, *options, scene=None):
    path = pathlib.Path(folder) / name
    subprocess.run([PROGRAM, "render", str(scene or SCENE), "-o", str(path), *SIZE, *options], check=True)
    return path


def channels(path):
    """Arrays of all channels by name."""
    part = OpenEXR.File(str(path), separate_channels=True).parts[0]
    return {name: channel.pixels for name, channel in part.channels.items()}


def expected_types(light):
    types = {name: light for name in "RGBA"}
    types |= {f"{light_pass}.{c}": light for light_pass in LIGHT_PASSES for c in "RGB"}
    types |= {f"{aov}.{c}": "float32" for aov in ["position", "normal", "geometric_normal"] for c in "XYZ"}
    types |= {f"albedo.{c}": "float32" for c in "RGB"}
    types |= {f"{direction}.{c}": "float32" for direction in ["forward", "backward"] for c in "uv"}
    types |= {name: "float32" for name in ["Z", "uv.U", "uv.V"]}
    types |= {name: "uint32" for name in ["object_id", "material_id", "node_id"]}
    mattes = ["crypto_object", "crypto_material"]
    types |= {f"{aov}{i:02}.{c}": "float32" for aov in mattes for i in range(3) for c in "RGBA"}
    return types


def check_channels(path, light, names=None):
    found = {name: str(pixels.dtype) for name, pixels in channels(path).items()}
    expected = expected_types(light)
    if names is not None:
        expected = {name: kind for name, kind in expected.items() if name in names}
    assert found == expected, (path, found, expected)


def check_with_openimageio(path):
    """Checks that OpenImageIO returns the same channel names and values."""
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
    """Checks that `worldToNDC` projects the position of each pixel's centre to that pixel."""
    pixels = channels(path)
    is_hit = pixels["node_id"] > 0
    rows, columns = numpy.nonzero(is_hit)
    ones = numpy.ones(len(rows))
    points = numpy.stack([pixels[f"position.{c}"][is_hit] for c in "XYZ"] + [ones], axis=1)
    ndc = points @ numpy.asarray(header["worldToNDC"], dtype=float)
    height, width = is_hit.shape
    x, y = ndc[:, 0] / ndc[:, 3] * width, ndc[:, 1] / ndc[:, 3] * height
    worst = max(abs(x - columns - 0.5).max(), abs(y - rows - 0.5).max())
    assert worst < 0.01, f"positions are {worst} pixels off"
    camera = points @ numpy.asarray(header["worldToCamera"], dtype=float)
    assert numpy.allclose(-camera[:, 2], pixels["Z"][is_hit], rtol=1e-4, atol=1e-4)


def check_sum(path):
    """Checks that the light passes sum to the beauty image, within two half-float steps for each."""
    pixels = channels(path)
    for c in "RGB":
        total = sum(pixels[f"{light_pass}.{c}"].astype(float) for light_pass in LIGHT_PASSES)
        beauty = pixels[c].astype(float)
        steps = numpy.abs(total - beauty) / numpy.maximum(numpy.abs(beauty), 2.0**-14)
        assert (steps < 8 * 2.0**-11).all(), (c, steps.max())


def murmur3(data):
    """MurmurHash3_x86_32 with seed 0."""
    mask, c1, c2, value = 0xFFFFFFFF, 0xCC9E2D51, 0x1B873593, 0
    rotate_left = lambda x, n: ((x << n) | (x >> (32 - n))) & mask
    body_length = len(data) // 4 * 4
    for at in range(0, body_length, 4):
        value ^= rotate_left(int.from_bytes(data[at : at + 4], "little") * c1 & mask, 15) * c2 & mask
        value = (rotate_left(value, 13) * 5 + 0xE6546B64) & mask
    if data[body_length:]:
        value ^= rotate_left(int.from_bytes(data[body_length:], "little") * c1 & mask, 15) * c2 & mask
    value ^= len(data)
    value = (value ^ value >> 16) * 0x85EBCA6B & mask
    value = (value ^ value >> 13) * 0xC2B2AE35 & mask
    return value ^ value >> 16


def mattes(path, wanted):
    """Coverage by name, decoded from the file alone."""
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
                    coverage_values = pixels[f"{wanted}{level:02}.{coverage}"]
                    matte = matte + numpy.where(ids == numpy.float32(value), coverage_values, 0.0)
            decoded[name] = matte
        return decoded
    raise AssertionError(f"{path} has no Cryptomatte {wanted}")


def isolate_node(scene, node, folder):
    """Writes the scene without the meshes of all other nodes, next to copies of its buffers and images."""
    document = json.loads(pathlib.Path(scene).read_text())
    for index, other in enumerate(document["nodes"]):
        if index != node:
            other.pop("mesh", None)
            other.pop("skin", None)
            other.pop("weights", None)
    for clip in document.get("animations", []):
        lost_its_mesh = lambda target: target["path"] == "weights" and target.get("node") != node
        clip["channels"] = [channel for channel in clip["channels"] if not lost_its_mesh(channel["target"])]
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
    """Checks that a node's matte is the alpha of that node alone, except where other nodes hide it."""
    decoded = mattes(path, "crypto_object")
    alpha = channels(path)["A"].astype(float)
    total = sum(decoded.values())
    assert numpy.abs(total - alpha).max() < 2e-3, f"the sum of the mattes differs from alpha by {numpy.abs(total - alpha).max()}"
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
        file = render(folder, f"alone{index}.####.exr", *options, scene=isolate_node(SCENE, index, folder))
        file = pathlib.Path(str(file).replace("####", "0002"))
        own = channels(file)["A"].astype(float)
        assert numpy.abs(mattes(file, "crypto_object")[own_name] - own).max() < 1e-3, name
        assert (decoded[name] <= own + 1e-3).all(), f"{name} covers more than it does alone"
        # Where no other node covers the pixel, the two are equal.
        free = numpy.abs(total - decoded[name]) < 1e-6
        assert numpy.abs(decoded[name] - own)[free].max(initial=0.0) < 1e-3, name
        compared += 1
    assert compared > 0
    return compared


def main():
    folder = pathlib.Path(tempfile.mkdtemp())
    numbered = lambda path: pathlib.Path(str(path).replace("####", "0002"))

    # One file with all AOVs, in every lossless compression.
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

    # Lossy compression of light passes, lossless compression of data.
    for compression in COMPRESSIONS[5:]:
        options = ["--layers", "all", "--background", "none", "--exr", f"float,{compression}", "--split-aovs"]
        main_file = numbered(render(folder, f"split_{compression}.####.exr", *options))
        check_channels(main_file, "float32", "RGBA")
        check_with_openimageio(main_file)
        for name in exact:
            aov = {"Z": "depth", "forward": "motion", "backward": "motion"}.get(name.split(".")[0], name.split(".")[0])
            aov = aov[:-2] if aov.startswith("crypto") else aov
            if name in "RGBA":
                continue
            file = folder / f"split_{compression}.{aov}.0002.exr"
            read = channels(file)[name]
            if aov in LIGHT_PASSES:
                error = numpy.abs(read.astype(float) - exact[name])
                assert (error <= 0.02 + 0.1 * numpy.abs(exact[name])).mean() > 0.99, (compression, name, error.max())
            else:
                assert numpy.array_equal(read, exact[name]), (compression, name)
            check_with_openimageio(file)

    compared = check_mattes(numbered(folder / "all_half_zip.####.exr"), folder)

    # `--stamp` adds attributes.
    header = OpenEXR.File(str(numbered(render(folder, "stamped.####.exr", "--stamp")))).header()
    assert header["renderSeconds"] > 0.0 and header["utcOffset"] == 0.0 and len(header["capDate"]) == 19
    print(f"all AOVs, attributes and {compared} mattes were read{'' if OpenImageIO else ' (OpenImageIO is missing)'}")


main()
