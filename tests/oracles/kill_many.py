#!/usr/bin/env python3
"""Stops runs at random moments, many times, and checks what is left, from outside the program.

    tests/oracles/kill_many.py target/release/rayframe [--kills 200] [--terms 50] [--disks 10] [--pairs 20] [--seed N]

A twenty-frame render without a break is the measure. Then, each round in a folder of its own:

- kills: `kill -9` after a random share of the time that a run takes; up to three in a row, then `--resume`.
- terms: SIGTERM; the program ends by the signal within a second, and what is finished stays.
- disks: the folder is a memory file system that is too small (needs root); the run ends with 74, then it is enlarged.
- pairs: two processes render the same frames into one folder; both end with 0.

A watcher reads the folder all the while: whatever has a frame's name must be that frame to the last byte. In the end the
folder holds the frames of the whole run and nothing else. Exits with 1 at the first departure, and prints the seed.
"""

import argparse
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

FRAMES = 20
SCENE = pathlib.Path(__file__).resolve().parents[2] / "scenes/demo/whitted_1980.gltf"


class Departure(Exception):
    pass


def command(program, folder, *more):
    return [program, "render", SCENE, "-o", folder / "a.####.exr", "-f", f"0-{FRAMES - 1}", "-r", "96x54",
            "--samples", "1", "--exr", "half,zip", "--progress", "plain", *more]


def start(program, folder, *more):
    return subprocess.Popen([str(word) for word in command(program, folder, *more)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def finish(process, expected):
    said = process.communicate(timeout=300)[1].decode()
    if process.returncode != expected:
        raise Departure(f"ended with {process.returncode}, not {expected}: {said}")
    return said


class Watcher:
    """Reads every file with a frame's name again and again, and counts how often one was whole."""

    def __init__(self, folder, whole):
        self.folder, self.whole, self.reads, self.broken = folder, whole, 0, None
        self.is_over = threading.Event()
        self.thread = threading.Thread(target=self.watch)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.is_over.set()
        self.thread.join()
        if self.broken and not sys.exc_info()[1]:
            raise Departure(f"{self.broken} was not whole while the program ran")

    def watch(self):
        while not self.is_over.is_set() and not self.broken:
            for name, content in self.whole.items():
                try:
                    read = (self.folder / name).read_bytes()
                except (FileNotFoundError, NotADirectoryError):
                    continue
                self.reads += 1
                if read != content:
                    self.broken = name
            time.sleep(0.002)


def check_left(folder, whole, is_complete):
    """Only whole frames, and temporaries unless the run is complete. Gives how many of each."""
    frames = temporaries = 0
    for path in folder.iterdir() if folder.exists() else []:
        if path.name in whole:
            frames += 1
            if path.read_bytes() != whole[path.name]:
                raise Departure(f"{path.name} is not whole")
        elif path.name.startswith(".a.") and path.name.endswith(".tmp") and not is_complete:
            temporaries += 1
        else:
            raise Departure(f"{path.name} was left")
    if is_complete and frames != len(whole):
        raise Departure(f"{frames} of {len(whole)} frames are there")
    return frames, temporaries


def kill_round(program, folder, whole, seconds, counts):
    with Watcher(folder, whole) as watcher:
        for _ in range(random.randint(1, 3)):
            if counts["left"] == 0:
                break
            process = start(program, folder, "--resume")
            time.sleep(random.uniform(0, seconds))
            process.kill()
            process.communicate()
            # A run that was over before it could be killed does not count.
            counts["left"] -= process.returncode == -signal.SIGKILL
            frames, temporaries = check_left(folder, whole, False)
            counts["cut short"] += frames < FRAMES
            counts["temporaries"] += temporaries
        finish(start(program, folder, "--resume"), 0)
    check_left(folder, whole, True)
    counts["reads"] += watcher.reads


def term_round(program, folder, whole, seconds, counts):
    with Watcher(folder, whole) as watcher:
        process = start(program, folder)
        # Later than the handlers are set: before, the signal ends the program as it does any other.
        time.sleep(random.uniform(0.05, seconds))
        before = sum((folder / name).exists() for name in whole)
        sent = time.monotonic()
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
        counts["slowest"] = max(counts["slowest"], time.monotonic() - sent)
        if process.returncode not in (0, -signal.SIGTERM):
            raise Departure(f"ended with {process.returncode}")
        counts["by the signal"] += process.returncode == -signal.SIGTERM
        frames, temporaries = check_left(folder, whole, False)
        if temporaries:
            raise Departure("a temporary was left after SIGTERM")
        if frames < before:
            raise Departure("a finished frame is gone")
        finish(start(program, folder, "--resume"), 0)
    check_left(folder, whole, True)
    counts["reads"] += watcher.reads


def disk_round(program, folder, whole, _, counts):
    folder.mkdir()
    total = sum(map(len, whole.values()))
    size = random.randint(total // 10, total * 9 // 10)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)], check=True)
    try:
        with Watcher(folder, whole) as watcher:
            said = finish(start(program, folder), 74)
            if "write failed" not in said:
                raise Departure(f"the message does not say what happened: {said}")
            frames, temporaries = check_left(folder, whole, False)
            if temporaries:
                raise Departure("a temporary was left on the full disk")
            counts["frames on full disks"] += frames
            subprocess.run(["mount", "-o", f"remount,size={total * 3}", str(folder)], check=True)
            finish(start(program, folder, "--resume"), 0)
        check_left(folder, whole, True)
        counts["reads"] += watcher.reads
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def pair_round(program, folder, whole, seconds, counts):
    with Watcher(folder, whole) as watcher:
        first = start(program, folder)
        time.sleep(random.choice([0, random.uniform(0, seconds / 2)]))
        second = start(program, folder)
        kept = [finish(process, 0).count(" kept") for process in (first, second)]
        counts["one found frames of the other"] += any(kept)
    check_left(folder, whole, True)
    counts["reads"] += watcher.reads


def main():
    options = argparse.ArgumentParser()
    options.add_argument("program", type=pathlib.Path)
    for name, count in (("kills", 200), ("terms", 50), ("disks", 10), ("pairs", 20)):
        options.add_argument(f"--{name}", type=int, default=count)
    options.add_argument("--seed", type=int, default=random.randrange(2**32))
    asked = options.parse_args()
    random.seed(asked.seed)
    print(f"seed {asked.seed}", flush=True)
    program = asked.program.resolve()

    with tempfile.TemporaryDirectory() as root:
        root = pathlib.Path(root)
        began = time.monotonic()
        finish(start(program, root / "whole"), 0)
        seconds = time.monotonic() - began
        whole = {path.name: path.read_bytes() for path in (root / "whole").iterdir()}
        print(f"{len(whole)} frames of {sum(map(len, whole.values()))} bytes in {seconds:.2f} s", flush=True)

        rounds = {"kills": kill_round, "terms": term_round, "disks": disk_round, "pairs": pair_round}
        for kind, run_round in rounds.items():
            counts = dict.fromkeys(["rounds", "reads", "cut short", "temporaries", "by the signal", "slowest",
                                    "frames on full disks", "one found frames of the other"], 0)
            counts["left"] = getattr(asked, kind)
            while counts["left"] > 0:
                counts["rounds"] += 1
                counts["left"] -= kind != "kills"
                folder = root / f"{kind}{counts['rounds']}"
                try:
                    run_round(program, folder, whole, seconds, counts)
                except Departure as departure:
                    sys.exit(f"{kind}, round {counts['rounds']}: {departure}")
                shutil.rmtree(folder)
            told = ", ".join(f"{name} {value:.3g}" if isinstance(value, float) else f"{name} {value}"
                             for name, value in counts.items() if value and name != "rounds")
            print(f"{kind}: {getattr(asked, kind)} in {counts['rounds']} rounds: {told}", flush=True)


main()
