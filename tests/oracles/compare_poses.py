#!/usr/bin/env python3
"""Compares the poses of animated glTF files with Blender's importer, vertex by vertex.

Needs the PyPI packages `bpy` and `numpy`; not part of the default tests.
Run from the project's root: python3 tests/oracles/compare_poses.py FILE[:CLIP]…

Both programs pose every animation of each file at the times of some of its keyframes. The printed figure is the largest distance from
a vertex of one to the nearest vertex of the other, divided by the diagonal of the bounds. Above 1e-3 the pose counts as wrong.
"""

import subprocess
import sys

import bpy
import numpy
from mathutils.kdtree import KDTree

LIMIT = 1e-3
TIMES = 6


def rayframe_points(path, clip, times):
    """World-space vertices at each time, posed by Rayframe."""
    command = ["cargo", "run", "-q", "--release", "-p", "oracles", "--bin", "dump_pose", "--", path, clip]
    text = subprocess.run(command + [repr(t) for t in times], check=True, capture_output=True, text=True).stdout
    lines = iter(text.splitlines())
    points = []
    for header in lines:
        count = int(header.split()[2])
        rows = [next(lines).split() for _ in range(count)]
        points.append(numpy.array(rows, dtype=float).reshape(-1, 3))
    return points


def animated():
    """All data blocks with animation tracks."""
    return [data for data in list(bpy.data.objects) + list(bpy.data.shape_keys) if data.animation_data]


def load_into_blender(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    # The importer starts every animation at frame 1. Time 0 is frame 0 here.
    for data in animated():
        for track in data.animation_data.nla_tracks:
            for strip in track.strips:
                shift = strip.action_frame_start - strip.frame_start
                strip.frame_start += shift
                strip.frame_end += shift


def clip_names():
    """Animations, each with the times of some of its keyframes, in seconds.

    Times between the keyframes of a rotation are not used: Blender interpolates along the chord, glTF along the arc. The times are
    slightly after the keyframes, where both programs have taken the steps of stepped channels.
    """
    fps = bpy.context.scene.render.fps / bpy.context.scene.render.fps_base
    keys = {}
    for data in animated():
        for track in data.animation_data.nla_tracks:
            for strip in track.strips:
                bags = [bag for layer in strip.action.layers for part in layer.strips for bag in part.channelbags]
                curves = [curve for bag in bags for curve in bag.fcurves]
                frames = {point.co[0] for curve in curves for point in curve.keyframe_points}
                keys.setdefault(track.name, set()).update(frame / fps + 1e-5 for frame in frames)
    return {name: sorted(times)[:: max(1, len(times) // TIMES)] for name, times in keys.items()}


def play_only(clip):
    for data in animated():
        data.animation_data.action = None
        for track in data.animation_data.nla_tracks:
            track.mute = track.name != clip
            track.is_solo = False


def blender_points(time):
    scene = bpy.context.scene
    frame = time * scene.render.fps / scene.render.fps_base
    scene.frame_set(int(frame), subframe=frame - int(frame))
    graph = bpy.context.evaluated_depsgraph_get()
    vertices = []
    for instance in graph.object_instances:
        if instance.object.type != "MESH" or instance.object.name.startswith("Icosphere"):
            continue
        mesh = instance.object.to_mesh()
        matrix = numpy.array(instance.matrix_world)
        local = numpy.empty(len(mesh.vertices) * 3)
        mesh.vertices.foreach_get("co", local)
        world = local.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        # Blender is Z up: its (x, y, z) is (x, z, -y) in glTF.
        vertices.append(numpy.stack([world[:, 0], world[:, 2], -world[:, 1]], axis=1))
        instance.object.to_mesh_clear()
    return numpy.concatenate(vertices)


def largest_distance(points, others):
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
        clips = {only: clip_names()[only]} if only else clip_names() or {"none": [0.0]}
        for clip, times in clips.items():
            # Load the file again, because a muted animation keeps its last pose.
            load_into_blender(path)
            play_only(clip)
            # Blender names unnamed animations Anim_0, Anim_1, …
            name = clip.replace("Anim_", "#")
            worst = 0.0
            for time, ours in zip(times, rayframe_points(path, name, times)):
                theirs = numpy.unique(blender_points(time), axis=0)
                ours = numpy.unique(ours, axis=0)
                diagonal = numpy.linalg.norm(theirs.max(axis=0) - theirs.min(axis=0))
                worst = max(worst, largest_distance(ours, theirs) / diagonal, largest_distance(theirs, ours) / diagonal)
            result = "ok" if worst <= LIMIT else "WRONG"
            wrong += worst > LIMIT
            print(f"{result:5} {worst:.2e}  {path}  {clip}  {len(times)} times", flush=True)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
