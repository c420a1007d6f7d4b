#!/usr/bin/env python3
"""Compares the poses of animated glTF files with Blender's importer, vertex by vertex.

Needs the PyPI packages `bpy` and `numpy`; not part of the default tests.
Run from the project's root: python3 tests/oracles/compare_poses.py FILE[:CLIP]…

For every file some times of each clip are posed by both programs. The figure printed is the largest distance from a
vertex of one to the nearest vertex of the other, as a share of the bounds' diagonal; above 1e-3 the pose counts as wrong.
"""

import subprocess
import sys

import bpy
import numpy
from mathutils.kdtree import KDTree

LIMIT = 1e-3
SHARES = (0.0, 0.13, 0.37, 0.5, 0.81)


def our_points(path, clip, times):
    """World-space corners a time, as Rayframe poses them."""
    command = ["cargo", "run", "-q", "--release", "--example", "dump_pose", "--", path, clip]
    text = subprocess.run(command + [repr(t) for t in times], check=True, capture_output=True, text=True).stdout
    lines = iter(text.splitlines())
    points = []
    for header in lines:
        count = int(header.split()[2])
        rows = [next(lines).split() for _ in range(count)]
        points.append(numpy.array(rows, dtype=float).reshape(-1, 3))
    return points


def load_into_blender(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)


def clip_names():
    """Clips in the file's order, with their length in seconds."""
    fps = bpy.context.scene.render.fps / bpy.context.scene.render.fps_base
    tracks = {}
    for data in list(bpy.data.objects) + [key for key in bpy.data.shape_keys]:
        for track in data.animation_data.nla_tracks if data.animation_data else []:
            end = max(strip.frame_end for strip in track.strips)
            tracks[track.name] = max(tracks.get(track.name, 0.0), end / fps)
    return tracks


def play_only(clip):
    for data in list(bpy.data.objects) + [key for key in bpy.data.shape_keys]:
        if data.animation_data:
            data.animation_data.action = None
            for track in data.animation_data.nla_tracks:
                track.mute = track.name != clip
                track.is_solo = False


def blender_points(time):
    scene = bpy.context.scene
    frame = time * scene.render.fps / scene.render.fps_base
    scene.frame_set(int(frame), subframe=frame - int(frame))
    graph = bpy.context.evaluated_depsgraph_get()
    corners = []
    for instance in graph.object_instances:
        if instance.object.type != "MESH" or instance.object.name.startswith("Icosphere"):
            continue
        mesh = instance.object.to_mesh()
        matrix = numpy.array(instance.matrix_world)
        local = numpy.empty(len(mesh.vertices) * 3)
        mesh.vertices.foreach_get("co", local)
        world = local.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        # Blender is Z up: (x, y, z) there is (x, z, -y) here.
        corners.append(numpy.stack([world[:, 0], world[:, 2], -world[:, 1]], axis=1))
        instance.object.to_mesh_clear()
    return numpy.concatenate(corners)


def farthest(points, others):
    tree = KDTree(len(others))
    for index, point in enumerate(others):
        tree.insert(point, index)
    tree.balance()
    return max(tree.find(point)[2] for point in points)


def main():
    wrong = 0
    for argument in sys.argv[1:]:
        path, _, only = argument.partition(":")
        load_into_blender(path)
        clips = {only: clip_names()[only]} if only else clip_names()
        for clip, seconds in (clips or {"none": 0.0}).items():
            play_only(clip)
            times = [seconds * share for share in SHARES] if seconds else [0.0]
            # Blender calls clips without a name Anim_0, Anim_1, …
            name = clip.replace("Anim_", "#") if seconds else "none"
            worst = 0.0
            for time, ours in zip(times, our_points(path, name, times)):
                theirs = numpy.unique(blender_points(time), axis=0)
                ours = numpy.unique(ours, axis=0)
                diagonal = numpy.linalg.norm(theirs.max(axis=0) - theirs.min(axis=0))
                worst = max(worst, farthest(ours, theirs) / diagonal, farthest(theirs, ours) / diagonal)
            verdict = "ok" if worst <= LIMIT else "WRONG"
            wrong += worst > LIMIT
            print(f"{verdict:5} {worst:.2e}  {path}  {clip}  {seconds:.2f} s", flush=True)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
