#!/usr/bin/env python3
"""Simulates chunk rules on a large farm, and counts what a frame asks of shared storage.

    python3 tests/oracles/farm_scale.py target/release/rayframe [--frames 10000] [--workers 100,1000] [--mean 120] [--load 20]

The times of three sequences are recorded with `--stats`: a clip, a turntable, and a camera that flies up to glass. Each is resampled to
--frames and scaled to a mean of --mean seconds. A task costs one second of the scheduler, --load seconds of reading and decoding the scene,
and its frames. Workers differ by 10 % (standard deviation) in speed, and take the next task of the list as soon as they are free. `--cost` knows
every 50th frame with an error of 10 %. The seed is fixed.

Printed are makespan (the end of the last task, hours) and waste (the part of the workers' time until then that renders no frame).

With strace, calls of a sequence are counted for 8 and for 24 frames; their difference is what a frame takes. With --metadata-only nothing
is simulated.
"""

import argparse
import collections
import heapq
import json
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile

SCENE = pathlib.Path(__file__).resolve().parents[2] / "scenes/demo/whitted_1980.gltf"
FLIGHT = """\
[[key]]
time = 0
position = [0, 2, 12]
look_at = [0, 1, 0]
[[key]]
time = 3
position = [0, 1, 1.2]
look_at = [0, 1, 0]
"""
SCHEDULER_SECONDS = 1.0
CALLS = "%file,fsync,fdatasync,flock,getdents64,fchmod,ftruncate"


def render(program, folder, *options):
    words = [program, "render", SCENE, "-o", folder / "a.####.exr", "-q", *options]
    subprocess.run([str(word) for word in words], check=True, stderr=subprocess.DEVNULL)


def recorded(program, folder):
    """Seconds of each frame of three sequences."""
    path = folder / "flight.toml"
    path.write_text(FLIGHT)
    sequences = {"clip": [], "turntable": ["--turntable", "96"], "flight to glass": ["--camera-path", path]}
    times = {}
    for name, options in sequences.items():
        out = folder / name
        out.mkdir()
        stats = folder / f"{name}.json"
        render(program, out, "-r", "128x72", "--samples", "4", "-t", "1", "--stats", stats, *options)
        times[name] = [frame["seconds"]["total"] for frame in json.loads(stats.read_text())["frames"]]
    return times


def resampled(times, frames, mean):
    """The profile over more frames, linear between recorded ones, with the given mean."""
    values = []
    for frame in range(frames):
        at = frame * (len(times) - 1) / max(frames - 1, 1)
        index = min(int(at), len(times) - 2)
        values.append(times[index] + (times[index + 1] - times[index]) * (at - index))
    scale = mean * frames / sum(values)
    return [value * scale for value in values]


def contiguous(costs, count):
    """Chunks whose ends are closest to equal shares of the costs, as `rayframe farm` makes them."""
    total, chunks, end, before = sum(costs), [], 0, 0.0
    for chunk in range(1, count + 1):
        first, last = end, len(costs) - (count - chunk)
        while end < last and (end == first or before + costs[end] / 2 <= total * chunk / count):
            before += costs[end]
            end += 1
        chunks.append(list(range(first, end if chunk < count else len(costs))))
    return chunks


def makespan(seconds, chunks, speeds, load):
    free = [(0.0, worker) for worker in range(len(speeds))]
    heapq.heapify(free)
    end = 0.0
    for chunk in chunks:
        time, worker = heapq.heappop(free)
        time += SCHEDULER_SECONDS + (load + sum(seconds[frame] for frame in chunk)) / speeds[worker]
        end = max(end, time)
        heapq.heappush(free, (time, worker))
    return end


def simulate(times, options):
    generator = random.Random(1)
    frames = options.frames
    print(f"{frames} frames of {options.mean:g} s on average, {options.load:g} s to load the scene")
    print(f"{'sequence':16} {'workers':>7}  {'rule':28} {'tasks':>6} {'makespan h':>11} {'waste':>7}")
    for name, recorded_times in times.items():
        seconds = resampled(recorded_times, frames, options.mean)
        known = [seconds[frame] * generator.gauss(1, 0.1) for frame in range(0, frames, 50)]
        measured = resampled(known, frames, options.mean)
        equal = [1.0] * frames
        for workers in options.workers:
            speeds = [max(0.5, generator.gauss(1, 0.1)) for _ in range(workers)]
            count = lambda chunk: -(-frames // chunk)
            share = -(-frames // workers)
            five_minutes = int(-(-sum(measured) // 300))
            rules = {
                "one task a worker": contiguous(equal, count(share)),
                "--chunk 1": contiguous(equal, frames),
                "--chunk 10": contiguous(equal, count(10)),
                "--chunk 10 --interleaved": [list(range(first, frames, count(10))) for first in range(count(10))],
                "--chunk 10 --cost": contiguous(measured, count(10)),
                "--cost (five minutes)": contiguous(measured, five_minutes),
            }
            for rule, chunks in rules.items():
                end = makespan(seconds, chunks, speeds, options.load)
                busy = sum(seconds)
                print(f"{name:16} {workers:>7}  {rule:28} {len(chunks):>6} {end / 3600:>11.2f} {1 - busy / (end * sum(speeds)):>7.1%}")


def counted_calls(program, folder, frames, more):
    log = folder / f"strace-{frames}"
    # The frames are new each time.
    out = folder / f"metadata-{frames}-{len(list(folder.iterdir()))}"
    words = ["strace", "-f", "-o", log, "-e", f"trace={CALLS}", program, "render", SCENE, "-o", out / "a.####.exr", "-r", "64x36",
             "--samples", "1", "-q", "-t", "2", "-f", f"0-{frames - 1}", *more]
    subprocess.run([str(word) for word in words], check=True, stderr=subprocess.DEVNULL)
    counts = collections.Counter()
    for line in log.read_text().splitlines():
        call = re.match(r"\d+ +(\w+)\(", line)
        # /proc and the program's own libraries are on no shared storage.
        if call and not re.search(r'"/(proc|sys|dev|etc|usr|lib)', line) and call[1] not in ("getcwd", "execve"):
            counts[call[1]] += 1
    return counts


def metadata(program, folder):
    if not shutil.which("strace"):
        print("skipped: strace is missing, which counts calls")
        return
    for options in [[], ["--resume"]]:
        few, many = (counted_calls(program, folder, frames, options) for frames in (8, 24))
        each = {name: (many[name] - few[name]) / 16 for name in many}
        shown = ", ".join(f"{name} {count:.2f}" for name, count in sorted(each.items()) if count > 0.05)
        print(f"calls a frame{' with --resume' if options else ''}: {shown}; in all {sum(each.values()):.1f}")
        print(f"calls of 8 frames: {sum(few.values())}, of 24: {sum(many.values())}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--workers", type=lambda text: [int(word) for word in text.split(",")], default=[100, 1000])
    parser.add_argument("--mean", type=float, default=120)
    parser.add_argument("--load", type=float, default=20)
    parser.add_argument("--metadata-only", action="store_true")
    options = parser.parse_args()
    program = options.program.resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        if not options.metadata_only:
            simulate(recorded(program, folder), options)
        metadata(program, folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
