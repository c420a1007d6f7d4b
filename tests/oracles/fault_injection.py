#!/usr/bin/env python3
"""Fails every system call on files, one by one, and checks the exit code, the message and the files that remain. Needs strace.

    tests/oracles/fault_injection.py target/release/rayframe [--only SCENARIO]

Each scenario is run once to count its calls of open, read, write, fsync, rename, unlink and others in each thread. Then it is run once for each number
up to the largest count, and strace lets the call of that number fail, in every thread that gets so far. After each run:

- the exit code is one of those that the scenario allows, and a failure prints one line of error at least and no panic;
- every file under a final name is whole: as a run without faults writes it, or as it was before;
- exit code 0 means that all files are there;
- the same run without faults then succeeds, and leaves no temporary file.

Calls of the dynamic loader, before the program starts, are not counted. Prints a table and every violation; ends with 1 where there is any.
"""

import argparse
import collections
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/light/point.gltf"
FAULTS = {"openat": "EMFILE", "read": "EIO", "write": "ENOSPC", "fsync": "EIO", "rename": "EACCES", "renameat": "EACCES",
          "renameat2": "EACCES", "unlink": "EACCES", "mkdir": "EACCES", "chmod": "EPERM", "fchmod": "EPERM", "statx": "EIO"}
SIZE = ["-r", "16x9", "--samples", "1"]
FAILURES = {65, 66, 73, 74, 75, 77}


class Scenario:
    """A command in a folder. `volatile` files differ between equal runs."""

    name = ""
    codes = {0}
    volatile = set()
    # Whether the exit code of success tells that all files are there.
    codes_tell = True

    def prepare(self, run, folder):
        pass

    def command(self):
        raise NotImplementedError

    def is_final(self, path):
        return not path.name.startswith(".")


class Render(Scenario):
    name = "render"
    # The manifest tells which frames were kept, and has no hash of a preview that cannot be read again.
    volatile = {"stats.json", "manifest.json"}

    def command(self):
        return ["render", SCENE, "-o", "a.####.exr", "-f", "0-1", *SIZE, "--preview", "png", "--manifest", "manifest.json", "--stats",
                "stats.json", "-q"]


class Resume(Render):
    name = "resume"

    def prepare(self, run, folder):
        run(["render", SCENE, "-o", "a.####.exr", "-f", "0", *SIZE, "--preview", "png", "-q"], folder)

    def command(self):
        return [*super().command(), "--resume"]


class Test(Scenario):
    name = "test"
    codes = {1}
    # A shot that cannot be read or stored fails as the changed one does.
    codes_tell = False
    volatile = {"index.html", "result.json"}

    def prepare(self, run, folder):
        text = SCENE.read_text()
        (folder / "point.gltf").write_text(text)
        for buffer in SCENE.parent.glob("*.bin"):
            shutil.copy(buffer, folder)
        (folder / "suite.toml").write_text("[shot]\nresolution = [16, 9]\nsamples = 1\n")
        run(["test", "-q"], folder, 1)
        run(["accept"], folder)
        (folder / "suite.toml").write_text("[shot]\nresolution = [16, 9]\nsamples = 1\nlight_scale = 3\n")

    def command(self):
        return ["test", "-q"]


class Accept(Test):
    name = "accept"
    codes = {0}
    codes_tell = True

    def prepare(self, run, folder):
        super().prepare(run, folder)
        run(["test", "-q"], folder, 1)

    def command(self):
        return ["accept"]


class Merge(Scenario):
    name = "merge"

    def prepare(self, run, folder):
        for name, crop in [("t1.exr", "0,0,16,4"), ("t2.exr", "0,4,16,9")]:
            run(["render", SCENE, "-o", name, "-f", "0", *SIZE, "--crop", crop, "-q"], folder)

    def command(self):
        return ["merge", "t1.exr", "t2.exr", "-o", "whole.exr"]


class Check(Render):
    name = "check"
    volatile = set()

    def prepare(self, run, folder):
        run(["render", SCENE, "-o", "a.####.exr", "-f", "0-1", *SIZE, "-q", "--manifest", "manifest.json"], folder)

    def command(self):
        return ["check", "--manifest", "manifest.json"]


def files(scenario, folder):
    """Content of all files with final names."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*"))
            if path.is_file() and scenario.is_final(path) and path.name not in scenario.volatile
            and ".rayframe-cache" not in path.parts}


def last_line(text):
    return (text.strip().splitlines() or [""])[-1][:300]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--only")
    options = parser.parse_args()
    program = options.program.resolve()

    def run(arguments, folder, code=0):
        ended = subprocess.run([program, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=60)
        if ended.returncode != code:
            sys.exit(f"{arguments}: ended with {ended.returncode} without a fault: {ended.stderr}")
        return ended

    table, violations = [], []
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        for scenario in [kind() for kind in (Render, Resume, Test, Accept, Merge, Check)]:
            if options.only in (None, scenario.name):
                rows = fail_all(scenario, program, run, place / scenario.name, violations)
                table.extend(rows)
    print(f"{'scenario':<10} {'call':<8} {'fault':<7} {'runs':>5} {'harmless':>9}  exit codes")
    for row in table:
        print(row)
    for violation in violations:
        print("VIOLATION", violation)
    print(f"{len(violations)} violations")
    sys.exit(bool(violations))


def fail_all(scenario, program, run, place, violations):
    # Without faults.
    before, after = place / "before", place / "after"
    before.mkdir(parents=True)
    scenario.prepare(run, before)
    shutil.copytree(before, after)
    log = place / "log"
    arguments = [str(word) for word in scenario.command()]
    strace = ["strace", "-f", "-qq", "-o", str(log)]
    traced = subprocess.run([*strace, "-e", "trace=" + ",".join(FAULTS), program, *arguments], cwd=after, capture_output=True, text=True)
    assert traced.returncode in scenario.codes, traced
    counts = {call: collections.Counter() for call in FAULTS}
    for line in log.read_text(errors="replace").splitlines():
        found = re.match(r"(\d+)\s+(\w+)\(", line)
        if found and found[2] in counts:
            counts[found[2]][found[1]] += 1
    expected, old = files(scenario, after), files(scenario, before)

    rows = []
    for call, error in FAULTS.items():
        codes, harmless, runs = collections.Counter(), 0, 0
        if not counts[call]:
            continue
        for number in range(1, max(counts[call].values(), default=0) + 1):
            folder = place / "run"
            shutil.rmtree(folder, ignore_errors=True)
            shutil.copytree(before, folder)
            fault = f"inject={call}:error={error}:when={number}"
            ended = subprocess.run([*strace, "-e", f"trace={call}", "-e", fault, program, *arguments], cwd=folder,
                                   capture_output=True, text=True, timeout=120)
            if "error while loading shared libraries" in ended.stderr or ended.returncode == 127:
                continue
            runs += 1
            codes[ended.returncode] += 1
            what = f"{scenario.name}: {call} {number} {error}: ended with {ended.returncode}: {last_line(ended.stderr)}"
            is_success = ended.returncode in scenario.codes
            harmless += is_success
            if not is_success and ended.returncode not in FAILURES | {1}:
                violations.append(f"{what}: no such exit code")
            if "panicked" in ended.stderr:
                violations.append(f"{what}: a panic")
            if not is_success and not (ended.stderr + ended.stdout).strip() and call != "write":
                violations.append(f"{what}: no message")
            left = files(scenario, folder)
            for name, content in left.items():
                if content not in (expected.get(name), old.get(name)):
                    violations.append(f"{what}: {name} is neither old nor new")
            for name in old:
                if name in expected and name not in left:
                    violations.append(f"{what}: {name} is lost")
            if is_success and scenario.codes_tell and call != "unlink" and left != expected:
                missing = sorted(set(expected) ^ set(left)) or [n for n in left if left[n] != expected[n]]
                violations.append(f"{what}: success, and {missing} differ")
            again = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True, timeout=60)
            whole = files(scenario, folder)
            # What was done before the fault need not be done again.
            if again.returncode not in scenario.codes | ({0} if scenario.name == "accept" else set()) or whole != expected:
                violations.append(f"{what}: then without a fault {again.returncode}: {last_line(again.stderr)}")
            temporary = [path.name for path in folder.rglob(".*.tmp")]
            if temporary:
                violations.append(f"{what}: {temporary} left after the next run")
        shown = ", ".join(f"{code}: {count}" for code, count in sorted(codes.items()))
        rows.append(f"{scenario.name:<10} {call:<8} {error:<7} {runs:>5} {harmless:>9}  {shown}")
    return rows


if __name__ == "__main__":
    main()
