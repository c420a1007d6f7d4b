#!/usr/bin/env python3
"""Whether `--bvh auto` chooses the fastest hierarchy for each asset.

    python3 tests/oracles/tree_kinds.py RAYFRAME [ASSET...] [--threads N] [--rounds N] [--size WxH]

Renders a still of each asset, by default all of ../shared/assets and scenes/, with every kind of tree in turn: plain and clustered, with and without
splits. What a kind costs is the time to build it and to answer all ray queries (`--stats`), the least of all rounds. The table gives how much longer
the frame takes with the automatic choice than with the fastest kind, in per cent of the frame without writing it. Kinds that made the same tree
(references, SAH cost, nodes and triangles that a ray visits) share the least of their times. At last come the assets over 3 % and the largest figure.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
KINDS = {
    "auto": [],
    "lbvh": ["--bvh", "lbvh", "--split", "off"],
    "ploc": ["--bvh", "ploc", "--split", "off"],
    "lbvh split": ["--bvh", "lbvh"],
    "ploc split": ["--bvh", "ploc"],
}
BUILD_STAGES = ("bounds", "split", "sort", "tree", "widen")
LIMIT = 0.03


def default_assets():
    shared = ROOT / "../shared/assets"
    found = [path for folder in (shared / "khronos", shared / "scenes", ROOT / "scenes") for path in folder.rglob("*.gl*")]
    return sorted(path for path in found if path.suffix in (".gltf", ".glb"))


def render(program, asset, kind, options, folder):
    """Tree, its builder, seconds of building and queries, and seconds of the frame without writing; nothing where the asset is refused."""
    stats = folder / "stats.json"
    stats.unlink(missing_ok=True)
    command = [program, "render", asset, "-o", folder / "a.exr", "-q", "--overwrite", "-f", "0", "-r", options.size, "-t", str(options.threads)]
    subprocess.run([*command, *KINDS[kind], "--stats", stats], capture_output=True, timeout=300)
    if not stats.exists():
        return None
    frame = json.loads(stats.read_text())["frames"][0]
    seconds, tree = frame["seconds"], frame["tree"]
    building = sum(seconds[stage] for stage in BUILD_STAGES)
    rays = frame["rays"]
    key = (tree["references"], tree["sah_cost"], rays["nodes_per_ray"], rays["triangles_per_ray"])
    return key, tree["builder"], building + rays["query_seconds"], seconds["total"] - seconds["write"]


def measure(program, asset, options, folder):
    """Least seconds of each tree, the tree of each kind, the builder and the least seconds of the frame by the automatic choice."""
    trees, least, frame, chosen = {}, {}, float("inf"), ""
    for _ in range(options.rounds):
        for kind in KINDS:
            run = render(program, asset, kind, options, folder)
            if run is None:
                return None
            key, builder, cost, total = run
            trees[kind] = key
            least[key] = min(cost, least.get(key, cost))
            if kind == "auto":
                frame, chosen = min(frame, total), builder
    return trees, least, chosen, frame


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("assets", nargs="*", type=pathlib.Path)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--size", default="640x360")
    options = parser.parse_args()
    program = options.program.resolve()
    slower, refused = {}, []
    print("| asset | boxes | auto | fastest | " + " | ".join(KINDS) + " | frame, ms | slower, % |")
    print("|---|---|---|---|" + "---|" * len(KINDS) + "---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for asset in options.assets or default_assets():
            result = measure(program, asset, options, pathlib.Path(folder))
            if result is None:
                refused.append(asset.name)
                continue
            trees, least, builder, frame = result
            fastest = min(KINDS, key=lambda kind: least[trees[kind]])
            excess = (least[trees["auto"]] - least[trees[fastest]]) / frame
            slower[asset.name] = excess
            references = trees["auto"][0]
            times = " | ".join(f"{1e3 * least[trees[kind]]:.2f}" for kind in KINDS)
            print(f"| {asset.stem} | {references} | {builder} | {fastest} | {times} | {1e3 * frame:.1f} | {100 * excess:.1f} |", flush=True)
    over = {name: excess for name, excess in slower.items() if excess > LIMIT}
    print(f"\n{len(slower)} assets, {len(over)} over {100 * LIMIT:.0f} %: {', '.join(over) or 'none'}; at most {100 * max(slower.values()):.1f} %")
    if refused:
        print(f"not rendered: {', '.join(refused)}")
    sys.exit(bool(over))


if __name__ == "__main__":
    main()
