"""A glTF asset as JSON, buffer views and images in memory, for scripts that edit assets: read, changed and written as .glb or .gltf."""

import base64
import io
import json
import pathlib
import struct
import urllib.parse

import numpy
from PIL import Image

TYPES = {5120: numpy.int8, 5121: numpy.uint8, 5122: numpy.int16, 5123: numpy.uint16, 5125: numpy.uint32, 5126: numpy.float32}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
CODES = {numpy.dtype(kind): code for code, kind in TYPES.items()}


class Asset:
    """`json` has no buffers; `views` are the bytes of its buffer views, `images` the MIME type and bytes of its images."""

    def __init__(self, path):
        path = pathlib.Path(path)
        content = path.read_bytes()
        self.path, chunk = path, None
        if content[:4] == b"glTF":
            length = struct.unpack_from("<I", content, 12)[0]
            self.json, chunk = json.loads(content[20:20 + length]), content[28 + length:]
        else:
            self.json = json.loads(content)
        buffers = [self._resource(buffer["uri"]) if "uri" in buffer else chunk for buffer in self.json.pop("buffers", [])]
        self.views = []
        for view in self.json.get("bufferViews", []):
            start = view.pop("byteOffset", 0)
            self.views.append(buffers[view.pop("buffer")][start:start + view.pop("byteLength")])
        self.images = []
        for image in self.json.get("images", []):
            if "uri" in image:
                encoded = self._resource(image.pop("uri"))
                kind = "image/png" if encoded[:4] == b"\x89PNG" else "image/jpeg"
            else:
                encoded, kind = self.views[image.pop("bufferView")], image.pop("mimeType")
            self.images.append((kind, encoded))

    def _resource(self, uri):
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (self.path.parent / urllib.parse.unquote(uri)).read_bytes()

    def of(self, kind, name):
        """Index of the first item of a list such as `materials` that has this name, or the index itself."""
        if isinstance(name, int):
            return name
        return next(i for i, item in enumerate(self.json[kind]) if item.get("name") == name)

    def material(self, name):
        return self.json["materials"][self.of("materials", name)]

    def node(self, name):
        return self.json["nodes"][self.of("nodes", name)]

    def primitives(self):
        return [primitive for mesh in self.json["meshes"] for primitive in mesh["primitives"]]

    def array(self, accessor):
        """The elements of an accessor as stored, one a row."""
        accessor = self.json["accessors"][accessor]
        kind, columns = numpy.dtype(TYPES[accessor["componentType"]]), COMPONENTS[accessor["type"]]
        view = self.json["bufferViews"][accessor["bufferView"]]
        stride = view.get("byteStride", kind.itemsize * columns)
        start = accessor.get("byteOffset", 0)
        strides = (stride, kind.itemsize)
        return numpy.ndarray((accessor["count"], columns), kind, self.views[accessor["bufferView"]], start, strides).copy()

    def set_array(self, accessor, values):
        """Replaces the elements of an accessor, in the type of `values`; each starts at a multiple of four bytes."""
        item = self.json["accessors"][accessor]
        values = numpy.ascontiguousarray(values)
        size = values.itemsize * values.shape[1]
        view = {}
        if item["type"] != "SCALAR" and size % 4:
            padded = numpy.zeros((len(values), -(-size // 4) * 4), numpy.uint8)
            padded[:, :size] = values.view(numpy.uint8).reshape(len(values), size)
            values_bytes, view["byteStride"] = padded.tobytes(), padded.shape[1]
        else:
            values_bytes = values.tobytes()
        item.update(bufferView=len(self.views), count=len(values), componentType=CODES[values.dtype])
        item.pop("byteOffset", None)
        if "min" in item:
            item["min"], item["max"] = values.min(axis=0).tolist(), values.max(axis=0).tolist()
        self.json.setdefault("bufferViews", []).append(view)
        self.views.append(values_bytes)

    def accessors_of(self, attribute):
        """Accessors of a vertex attribute, each once."""
        return sorted({p["attributes"][attribute] for p in self.primitives() if attribute in p["attributes"]})

    def image(self, index):
        return Image.open(io.BytesIO(self.images[index][1]))

    def set_image(self, index, image, kind="PNG", **options):
        stream = io.BytesIO()
        image.save(stream, kind, **options)
        self.images[index] = (f"image/{kind.lower()}", stream.getvalue())

    def _packed(self, order=None):
        """The JSON with one buffer, and its bytes: buffer views in `order`, then images."""
        content, blob = json.loads(json.dumps(self.json)), bytearray()

        def add(view, chunk):
            blob.extend(bytes(-len(blob) % 4))
            view.update(buffer=0, byteOffset=len(blob), byteLength=len(chunk))
            blob.extend(chunk)

        views = content.setdefault("bufferViews", [])
        for index in order or range(len(views)):
            add(views[index], self.views[index])
        for image, (kind, chunk) in zip(content.get("images", []), self.images):
            image.update(bufferView=len(views), mimeType=kind)
            views.append({})
            add(views[-1], chunk)
        content["buffers"] = [{"byteLength": len(blob)}]
        return content, bytes(blob)

    def write(self, path, order=None):
        """Writes a .glb, or a .gltf with a .bin beside it."""
        path = pathlib.Path(path)
        content, blob = self._packed(order)
        if path.suffix == ".gltf":
            content["buffers"][0]["uri"] = path.with_suffix(".bin").name
            path.with_suffix(".bin").write_bytes(blob)
            path.write_text(json.dumps(content), encoding="utf-8")
            return
        text, blob = json.dumps(content).encode(), blob + bytes(-len(blob) % 4)
        text += b" " * (-len(text) % 4)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blob)))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", len(blob), b"BIN\0") + blob)
