#!/usr/bin/env python3
"""Crash test: kills or stops runs at random moments and checks the files that remain.

    tests/oracles/kill_many.py target/release/rayframe [--kills 200] [--terms 50] [--disks 10] [--pairs 20] [--seed N]

An uninterrupted twenty-frame render gives the expected files and the duration. Each following round has its own folder:

- kills: `kill -9` after a random part of the duration, up to three times in a row, then `--resume`.
- terms: SIGTERM. The program terminates by the signal within a second, and finished frames remain.
- disks: the folder is a memory file system that is too small (needs root). The exit code is 74. Then the file system is enlarged.
- pairs: two processes share the frames of one folder (`--resume`). In half of the rounds one is killed; the other renders what it leaves.

A watcher reads the folder throughout: every file with the name of a frame must equal that frame. At the end the folder must hold the
frames of the uninterrupted run and nothing else. The first failure ends the test with exit code 1. The seed is printed.
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


class Failure(Exception):
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
        raise Failure(f"ended with {process.returncode}, not {expected}: {said}")
    return said


class Watcher:
    """Reads every file with the name of a frame repeatedly, and counts the reads."""

    def __init__(self, folder, expected):
        self.folder, self.expected, self.reads, self.broken = folder, expected, 0, None
        self.is_over = threading.Event()
        self.thread = threading.Thread(target=self.watch)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.is_over.set()
        self.thread.join()
        if self.broken and not sys.exc_info()[1]:
            raise Failure(f"{self.broken} was incomplete while the program ran")

    def watch(self):
        while not self.is_over.is_set() and not self.broken:
            for name, content in self.expected.items():
                try:
                    read = (self.folder / name).read_bytes()
                except (FileNotFoundError, NotADirectoryError):
                    continue
                self.reads += 1
                if read != content:
                    self.broken = name
            time.sleep(0.002)


def check_files(folder, expected, is_complete):
    """Checks that only complete frames remain, and temporary files unless the run is complete. Returns the number of each."""
    frames = temporaries = 0
    for path in folder.iterdir() if folder.exists() else []:
        if path.name in expected:
            frames += 1
            if path.read_bytes() != expected[path.name]:
                raise Failure(f"{path.name} is incomplete")
        elif path.name.startswith(".a.") and path.name.endswith((".tmp", ".lock", ".run", ".claim")) and not is_complete:
            temporaries += 1
        else:
            raise Failure(f"{path.name} was left behind")
    if is_complete and frames != len(expected):
        raise Failure(f"{frames} of {len(expected)} frames exist")
    return frames, temporaries


def kill_round(program, folder, expected, seconds, counts):
    with Watcher(folder, expected) as watcher:
        for _ in range(random.randint(1, 3)):
            if counts["left"] == 0:
                break
            process = start(program, folder, "--resume")
            time.sleep(random.uniform(0, seconds))
            process.kill()
            process.communicate()
            # A run that ended before it was killed does not count.
            counts["left"] -= process.returncode == -signal.SIGKILL
            frames, temporaries = check_files(folder, expected, False)
            counts["cut short"] += frames < FRAMES
            counts["temporaries"] += temporaries
        finish(start(program, folder, "--resume"), 0)
    check_files(folder, expected, True)
    counts["reads"] += watcher.reads


def term_round(program, folder, expected, seconds, counts):
    with Watcher(folder, expected) as watcher:
        process = start(program, folder)
        # Wait until the signal handlers are installed. Before, the signal ends the program directly.
        time.sleep(random.uniform(0.05, seconds))
        before = sum((folder / name).exists() for name in expected)
        sent = time.monotonic()
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
        counts["slowest"] = max(counts["slowest"], time.monotonic() - sent)
        if process.returncode not in (0, -signal.SIGTERM):
            raise Failure(f"ended with {process.returncode}")
        counts["by the signal"] += process.returncode == -signal.SIGTERM
        frames, temporaries = check_files(folder, expected, False)
        if temporaries:
            raise Failure("a temporary was left after SIGTERM")
        if frames < before:
            raise Failure("a finished frame is missing")
        finish(start(program, folder, "--resume"), 0)
    check_files(folder, expected, True)
    counts["reads"] += watcher.reads


def disk_round(program, folder, expected, _, counts):
    folder.mkdir()
    total = sum(map(len, expected.values()))
    size = random.randint(total // 10, total * 9 // 10)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)], check=True)
    try:
        with Watcher(folder, expected) as watcher:
            said = finish(start(program, folder), 74)
            if "write failed" not in said:
                raise Failure(f"unexpected message: {said}")
            frames, temporaries = check_files(folder, expected, False)
            if temporaries:
                raise Failure("a temporary was left on the full disk")
            counts["frames on full disks"] += frames
            subprocess.run(["mount", "-o", f"remount,size={total * 3}", str(folder)], check=True)
            finish(start(program, folder, "--resume"), 0)
        check_files(folder, expected, True)
        counts["reads"] += watcher.reads
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def pair_round(program, folder, expected, seconds, counts):
    with Watcher(folder, expected) as watcher:
        first = start(program, folder, "--resume")
        time.sleep(random.choice([0, random.uniform(0, seconds / 2)]))
        second = start(program, folder, "--resume")
        if random.random() < 0.5:
            time.sleep(random.uniform(0, seconds))
            first.kill()
            first.communicate(timeout=60)
        else:
            finish(first, 0)
        counts["one found frames of the other"] += finish(second, 0).count(" kept") > 0
        # What a killed process leaves is removed by the next one.
        finish(start(program, folder, "--resume"), 0)
    check_files(folder, expected, True)
    counts["reads"] += watcher.reads


def main():
    options = argparse.ArgumentParser()
    options.add_argument("program", type=pathlib.Path)
    for name, count in (("kills", 200), ("terms", 50), ("disks", 10), ("pairs", 20)):
        options.add_argument(f"--{name}", type=int, default=count)
    options.add_argument("--seed", type=int, default=random.randrange(2**32))
    arguments = options.parse_args()
    random.seed(arguments.seed)
    print(f"seed {arguments.seed}", flush=True)
    program = arguments.program.resolve()

    with tempfile.TemporaryDirectory() as root:
        root = pathlib.Path(root)
        started = time.monotonic()
        finish(start(program, root / "expected"), 0)
        seconds = time.monotonic() - started
        expected = {path.name: path.read_bytes() for path in (root / "expected").iterdir()}
        print(f"{len(expected)} frames of {sum(map(len, expected.values()))} bytes in {seconds:.2f} s", flush=True)

        rounds = {"kills": kill_round, "terms": term_round, "disks": disk_round, "pairs": pair_round}
        for kind, run_round in rounds.items():
            counts = dict.fromkeys(["rounds", "reads", "cut short", "temporaries", "by the signal", "slowest",
                                    "frames on full disks", "one found frames of the other"], 0)
            counts["left"] = getattr(arguments, kind)
            while counts["left"] > 0:
                counts["rounds"] += 1
                counts["left"] -= kind != "kills"
                folder = root / f"{kind}{counts['rounds']}"
                try:
                    run_round(program, folder, expected, seconds, counts)
                except Failure as failure:
                    sys.exit(f"{kind}, round {counts['rounds']}: {failure}")
                shutil.rmtree(folder)
            summary = ", ".join(f"{name} {value:.3g}" if isinstance(value, float) else f"{name} {value}"
                             for name, value in counts.items() if value and name != "rounds")
            print(f"{kind}: {getattr(arguments, kind)} in {counts['rounds']} rounds: {summary}", flush=True)


main()
