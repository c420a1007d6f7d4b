#!/usr/bin/env python3
"""Crash test of suites: ends `rayframe test` and `rayframe accept` by signals at random moments and checks the references.

    tests/oracles/kill_suites.py target/release/rayframe [--signals 1000] [--shots 12] [--seed N]

A suite with accepted references gets other settings, so that each image fails and `accept` replaces each reference. An uninterrupted run gives
the old and the new references, the pending images, and the durations. In each round, in a folder of its own, `test` and then `accept` (in
half of the rounds by a file of approvals) get SIGTERM, SIGINT, SIGHUP or SIGKILL after a random part of their duration. After each signal:

- every reference is the old or the new one, to the last byte; every pending image is whole; none is lost;
- what is not accepted is still pending after `accept`, or its reference is the new one;
- report, result and approvals are whole, or were not written;
- SIGTERM and SIGINT end the program by the signal, or it had ended.

Then the same commands without signals must end as usual, and leave the new references and no temporary file. The first failure ends the test with
exit code 1. The seed is printed.
"""

import argparse
import collections
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

SCENE = pathlib.Path(__file__).resolve().parents[2] / "scenes/light/point.gltf"
SIGNALS = [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGKILL]
SUITE = "[shot]\nresolution = [48, 27]\nsamples = 1\nframes = 0\n"
APPROVALS = "approvals.json"
CHANGED = SUITE + "light_scale = 3\n"


class Failure(Exception):
    pass


def start(program, folder, words):
    environment = {name: value for name, value in os.environ.items() if name != "CI"}
    return subprocess.Popen([program, *words], cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, preexec_fn=take_signals)


def take_signals():
    """Processes in the background of a shell ignore some."""
    for kind in (signal.SIGINT, signal.SIGHUP):
        signal.signal(kind, signal.SIG_DFL)


def run(program, folder, words, codes):
    process = start(program, folder, words)
    said = process.communicate(timeout=120)[0].decode()
    if process.returncode not in codes:
        raise Failure(f"{words} ended with {process.returncode}: {said}")
    return said


def timed(program, folder, words, codes):
    started = time.monotonic()
    run(program, folder, words, codes)
    return time.monotonic() - started


def references(folder):
    """Bytes of the references and of the pending images by name."""
    read = {path.name: path.read_bytes() for path in (folder / "references").rglob("*") if path.is_file()
            and not path.name.startswith(".")}
    pending = {name.removesuffix(".new"): content for name, content in read.items() if name.endswith(".new")}
    return {name: content for name, content in read.items() if not name.endswith(".new")}, pending


def interrupt(program, folder, words, seconds, counts):
    """Sends a signal after a random part of the duration."""
    kind = random.choice(SIGNALS)
    process = start(program, folder, words)
    time.sleep(random.uniform(0, seconds))
    process.send_signal(kind)
    said = process.communicate(timeout=60)[0].decode()
    # A process that ended before does not count.
    if process.returncode == -kind:
        counts[kind.name] += 1
        counts[words[0]] += 1
    elif process.returncode != (words[0] == "test"):
        raise Failure(f"{words} ended with {process.returncode} after {kind.name}: {said}")
    if "panicked" in said:
        raise Failure(f"{words} panicked after {kind.name}: {said}")


def check(folder, expected, is_accepting, counts):
    """Checks all files after a signal."""
    old, new, stored = expected
    now, pending = references(folder)
    for name in old:
        if name not in now:
            raise Failure(f"{name} is lost")
        if now[name] not in (old[name], new[name]):
            raise Failure(f"{name} is neither the old nor the new reference")
        if not is_accepting and now[name] != old[name]:
            raise Failure(f"{name} was changed by a test")
        if is_accepting and now[name] == old[name] and name not in pending:
            raise Failure(f"the pending image of {name} is lost")
        counts["references replaced"] += now[name] == new[name]
    for name, content in pending.items():
        if content != stored[name]:
            raise Failure(f"the pending image of {name} is not whole")
    for path in folder.rglob("result.json"):
        json.loads(path.read_text())
    for path in folder.rglob("index.html"):
        if not path.read_text().rstrip().endswith("</html>"):
            raise Failure("the report is not whole")
    counts["temporary files of killed runs"] += len(list(folder.rglob(".*.tmp")))


def approve_all(folder):
    """Writes the file of approvals of all pending images. Returns its bytes."""
    shots = json.loads((folder / "report/result.json").read_text())["shots"]
    approved = [{"name": image["name"], "hash": image["hash"]} for shot in shots for image in shot["pictures"]]
    content = json.dumps({"schema": 1, "approved": approved}).encode()
    (folder / APPROVALS).write_bytes(content)
    return content


def round_of(program, before, folder, expected, seconds, counts):
    shutil.copytree(before, folder)
    for _ in range(random.randint(1, 2)):
        interrupt(program, folder, ["test", "-q"], seconds["test"], counts)
        check(folder, expected, False, counts)
    run(program, folder, ["test", "-q"], {1})
    accept, approved = ["accept"], None
    if random.random() < 0.5:
        accept, approved = ["accept", "--approvals", APPROVALS], approve_all(folder)
    interrupt(program, folder, accept, seconds["accept"], counts)
    check(folder, expected, True, counts)
    if approved and (folder / APPROVALS).read_bytes() != approved:
        raise Failure("the approvals changed")

    # The next runs end what was begun.
    run(program, folder, ["test", "-q"], {0, 1})
    run(program, folder, ["accept"], {0})
    run(program, folder, ["test", "-q"], {0})
    now, pending = references(folder)
    if now != expected[1] or pending:
        raise Failure("the references are not the new ones at the end")
    left = [path.name for path in folder.rglob(".*") if path.is_file() and path.suffix in (".tmp", ".lock", ".run", ".claim")]
    if left:
        raise Failure(f"{left} were left behind")


def prepare(program, root, shots):
    """Folders of the suite before and after, its references, and the durations."""
    before = root / "before"
    before.mkdir()
    for number in range(shots):
        shutil.copy(SCENE, before / f"shot{number:02}.gltf")
    (before / "suite.toml").write_text(SUITE)
    run(program, before, ["test", "-q"], {1})
    run(program, before, ["accept"], {0})
    (before / "suite.toml").write_text(CHANGED)
    old, _ = references(before)
    after = root / "after"
    shutil.copytree(before, after)
    seconds = {"test": timed(program, after, ["test", "-q"], {1})}
    _, stored = references(after)
    seconds["accept"] = timed(program, after, ["accept"], {0})
    new, _ = references(after)
    return before, (old, new, stored), seconds


def main():
    options = argparse.ArgumentParser()
    options.add_argument("program", type=pathlib.Path)
    options.add_argument("--signals", type=int, default=1000)
    options.add_argument("--shots", type=int, default=12)
    options.add_argument("--seed", type=int, default=random.randrange(2**32))
    arguments = options.parse_args()
    random.seed(arguments.seed)
    print(f"seed {arguments.seed}", flush=True)
    program = arguments.program.resolve()

    counts = collections.Counter()
    with tempfile.TemporaryDirectory() as root:
        root = pathlib.Path(root)
        before, expected, seconds = prepare(program, root, arguments.shots)
        print(f"{len(expected[0])} references; test {seconds['test']:.2f} s, accept {seconds['accept']:.2f} s", flush=True)
        while sum(counts[kind.name] for kind in SIGNALS) < arguments.signals:
            counts["rounds"] += 1
            folder = root / f"round{counts['rounds']}"
            try:
                round_of(program, before, folder, expected, seconds, counts)
            except Failure as failure:
                sys.exit(f"round {counts['rounds']}: {failure}")
            shutil.rmtree(folder)
    print(", ".join(f"{name} {count}" for name, count in sorted(counts.items())))


main()
