"""What the scripts that compare renderers share: runs of Rayframe, its camera, scenes in Blender's Cycles, and differences of images.

Cycles needs `bpy`, Blender as a Python module: `pip install bpy` or a wheel from https://download.blender.org/pypi/.
"""

import contextlib
import json
import math
import os
import pathlib
import resource
import subprocess
import tempfile
import time

import numpy
import OpenEXR

ASSETS = pathlib.Path(__file__).resolve().parents[2] / "../shared/assets"
ASSETS_HELP = "folder with khronos/, scenes/, env/ and goldens/ (default: ../shared/assets beside the project)"


def read_exr(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()

        def pixels(name):
            return next(v.pixels for k, v in channels.items() if k == name or k.endswith("Combined." + name))

        return numpy.stack([pixels(name).astype(numpy.float64) for name in "RGB"], axis=-1), dict(file.header())


def display(linear):
    """sRGB-encoded values of clipped linear light."""
    clipped = numpy.clip(numpy.nan_to_num(linear), 0.0, 1.0)
    return numpy.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def difference(a, b):
    return float(numpy.abs(display(a) - display(b)).mean())


def rayframe(program, scene, *options, threads=None):
    """Renders one frame. Returns linear light, the camera, and a dictionary with the seconds of tracing and of the processor."""
    with tempfile.TemporaryDirectory() as folder:
        output, stats = os.path.join(folder, "frame.exr"), os.path.join(folder, "stats.json")
        command = [str(program), "render", str(scene), "-o", output, "--stats", stats, "--overwrite", "-q", "--exr=float,zips",
                   *map(str, options)]
        command += [f"--threads={threads}"] if threads else []
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        ran = subprocess.run(command, capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if ran.returncode:
            raise SystemExit(f"{' '.join(command)}\n{ran.stderr}")
        image, header = read_exr(output)
        with open(stats, encoding="utf-8") as file:
            seconds = json.load(file)["frames"][0]["seconds"]
    cpu = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return image, Camera(header), {"trace": seconds["trace"], "total": seconds["total"], "cpu": cpu}


class Camera:
    """Position, axes and lens of an EXR file's attributes; glTF's axes."""

    def __init__(self, header):
        self.world_to_camera = numpy.array(header["worldToCamera"], dtype=float).T
        projection = numpy.linalg.inv(self.world_to_camera.T) @ numpy.array(header["worldToNDC"], dtype=float)
        self.camera_to_world = numpy.linalg.inv(self.world_to_camera)
        self.fov_y = 2.0 * math.atan(0.5 / abs(projection[1, 1]))
        self.near = 1e-3 * max(1.0, float(numpy.linalg.norm(self.camera_to_world[:3, 3])))


# Radians about the vertical axis from the middle of an equirectangular image in Rayframe to that in Blender, which is at its +X.
ENVIRONMENT_TURN = -math.pi / 2
Z_UP = numpy.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)


@contextlib.contextmanager
def quiet():
    """Keeps what Blender writes to the standard output, from C as well, away from tables."""
    saved, sink = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    try:
        yield
    finally:
        os.dup2(saved, 1)
        os.close(saved)
        os.close(sink)


class Cycles:
    """A glTF scene in Cycles, with the camera of Rayframe and without other light than the environment's and the file's."""

    def __init__(self, scene, camera, size, environment=None, frame=0, depth=8, threads=None):
        import bpy
        self.bpy = bpy
        with quiet():
            bpy.ops.wm.read_factory_settings(use_empty=True)
            bpy.context.scene.render.fps = 24
            if scene is not None:
                # COMPAT keeps a candela one watt per steradian, as Rayframe does.
                bpy.ops.import_scene.gltf(filepath=str(pathlib.Path(scene).resolve()), disable_bone_shape=True,
                                          export_import_convert_lighting_mode="COMPAT")
        self.scene = bpy.context.scene
        self._default_material()
        self.scene.frame_set(frame)
        self._camera(camera, size)
        self._environment(environment)
        self._settings(size, depth, threads)

    def _default_material(self):
        """glTF's, of rough white metal, where a mesh has none; Blender's own is grey plastic."""
        for node in self.scene.objects:
            if node.type == "MESH" and not any(slot.material for slot in node.material_slots):
                material = self.bpy.data.materials.new("default")
                material.use_nodes = True
                bsdf = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
                bsdf.inputs["Base Color"].default_value = (1.0, 1.0, 1.0, 1.0)
                bsdf.inputs["Metallic"].default_value = bsdf.inputs["Roughness"].default_value = 1.0
                node.data.materials.clear()
                node.data.materials.append(material)

    def _camera(self, camera, size):
        import mathutils
        self.bpy.ops.object.camera_add()
        node = self.bpy.context.object
        data = node.data
        data.sensor_fit, data.angle_y = "VERTICAL", camera.fov_y
        data.clip_start, data.clip_end = camera.near, camera.near * 1e7
        node.matrix_world = mathutils.Matrix((Z_UP @ camera.camera_to_world).tolist())
        self.scene.camera = node

    def _environment(self, path):
        world = self.scene.world = self.bpy.data.worlds.new("oracle")
        world.use_nodes = True
        nodes, links = world.node_tree.nodes, world.node_tree.links
        background = next(n for n in nodes if n.type == "BACKGROUND")
        background.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
        if path is None:
            return
        image = nodes.new("ShaderNodeTexEnvironment")
        image.image = self.bpy.data.images.load(str(pathlib.Path(path).resolve()))
        image.image.colorspace_settings.name = "Linear Rec.709"
        mapping, coordinates = nodes.new("ShaderNodeMapping"), nodes.new("ShaderNodeTexCoord")
        # Rayframe has the middle of the image at -Z, Blender at its +X.
        mapping.inputs["Rotation"].default_value = (0.0, 0.0, ENVIRONMENT_TURN)
        links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
        links.new(mapping.outputs["Vector"], image.inputs["Vector"])
        links.new(image.outputs["Color"], background.inputs["Color"])
        world.cycles.sampling_method = "MANUAL"
        world.cycles.sample_map_resolution = 1024

    def _settings(self, size, depth, threads):
        render, cycles = self.scene.render, self.scene.cycles
        render.engine, cycles.device = "CYCLES", "CPU"
        render.resolution_x, render.resolution_y, render.resolution_percentage = *size, 100
        render.film_transparent, render.use_compositing, render.use_sequencer = False, False, False
        render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
        render.use_persistent_data = False
        if threads:
            render.threads_mode, render.threads = "FIXED", threads
        cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_auto_tile = cycles.use_fast_gi = False
        cycles.pixel_filter_type, cycles.blur_glossy, cycles.light_sampling_threshold = "BOX", 0.0, 0.0
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
        cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = depth
        cycles.transparent_max_bounces = 256
        self.scene.view_settings.view_transform = "Raw"

    def blur(self, frames):
        """An open shutter about the frame's time."""
        self.scene.render.use_motion_blur, self.scene.render.motion_blur_shutter = True, frames
        self.scene.render.motion_blur_position = "CENTER"

    def render(self, samples, seed=0):
        """Linear light, and a dictionary with the seconds of tracing and of the processor."""
        self.scene.cycles.samples, self.scene.cycles.seed = samples, seed
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "frame.exr")
            self.scene.render.filepath = path
            begin, cpu = time.perf_counter(), time.process_time()
            with quiet():
                self.bpy.ops.render.render(write_still=True)
            total, cpu = time.perf_counter() - begin, time.process_time() - cpu
            image, header = read_exr(path)
        traced = next((v for k, v in header.items() if k.startswith("cycles.") and k.endswith(".render_time")), None)
        return image, {"trace": clock(traced) if traced else total, "total": total, "cpu": cpu}


def clock(text):
    """Seconds of `01:02.34`."""
    seconds = 0.0
    for part in str(text).rstrip("s").split(":"):
        seconds = 60.0 * seconds + float(part)
    return seconds
