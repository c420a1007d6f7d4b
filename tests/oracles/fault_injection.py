#!/usr/bin/env python3
"""Fails every system call on files, memory and threads, one by one, and checks the exit code, the message and the files that remain. Needs strace.

    tests/oracles/fault_injection.py target/release/rayframe [--only SCENARIO] [--calls openat,mmap,memory,limit]

Each scenario is run once to count its calls of open, read, write, fsync, rename, unlink, mmap, clone and others in each thread. Then it is run once for
each number up to the largest count, and strace lets the call of that number fail, in every thread that gets so far. Two faults last: `memory` refuses
all memory from the call of a number on, and `limit` runs the program in address spaces from too small to large enough. After each run:

- the exit code is one of those that the scenario allows, and a failure prints one line of error at least and no panic;
- every file under a final name is whole: as a run without faults writes it, or as it was before;
- exit code 0 means that all files are there;
- the same run without faults then succeeds, and leaves no temporary file.

Calls before the program starts, of the dynamic loader and the standard library, are not failed. Closing a folder cannot fail in the standard library,
which panics (70): `close` may end so. Prints a table and every violation; ends with 1 where there is any.
"""

import argparse
import collections
import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/light/point.gltf"
FAULTS = {"openat": "EMFILE", "read": "EIO", "write": "ENOSPC", "fsync": "EIO", "rename": "EACCES", "renameat": "EACCES",
          "renameat2": "EACCES", "unlink": "EACCES", "mkdir": "EACCES", "chmod": "EPERM", "fchmod": "EPERM", "statx": "EIO",
          "close": "EIO", "ftruncate": "ENOSPC", "fallocate": "ENOSPC", "pwrite64": "ENOSPC", "getdents64": "EIO", "lseek": "EIO", "fcntl": "EMFILE",
          "flock": "ENOLCK", "readlink": "EIO", "clone3": "EAGAIN", "mmap": "ENOMEM", "brk": "ENOMEM", "mprotect": "ENOMEM"}
# The program gives aborts an exit code as its first act.
FIRST_ACT = "rt_sigaction(SIGABRT, {"
MEGABYTE = 1 << 20
# Address spaces of `limit`, in half megabytes.
LIMITS = range(32, 200)
SIZE = ["-r", "16x9", "--samples", "1"]
# Else estimates refuse a small address space before an allocation fails.
MEMORY = ["--max-memory", "1G"]
FAILURES = {65, 66, 73, 74, 75, 77}


class Scenario:
    """A command in a folder. `volatile` files differ between equal runs."""

    name = ""
    codes = {0}
    volatile = set()
    # Codes of the run after the fault, beside those.
    again = set()
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
                "stats.json", "-q", *MEMORY]


class Movie(Scenario):
    name = "movie"

    def command(self):
        return ["render", SCENE, "-o", "film.apng", "--overwrite", "-f", "0-1", *SIZE, "--contact-sheet", "sheet.png", "-q", *MEMORY]


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
        return ["test", "-q", *MEMORY]


class Accept(Test):
    name = "accept"
    codes = {0}
    again = {0}
    codes_tell = True

    def prepare(self, run, folder):
        super().prepare(run, folder)
        run(["test", "-q"], folder, 1)

    def command(self):
        return ["accept"]


class Approve(Accept):
    name = "approve"
    # All is accepted, or nothing; then the approvals match no pending image.
    again = {0, 1}

    def prepare(self, run, folder):
        super().prepare(run, folder)
        shots = json.loads((folder / "report/result.json").read_text())["shots"]
        approved = [{"name": image["name"], "hash": image["hash"]} for shot in shots for image in shot["pictures"]]
        (folder / "approvals.json").write_text(json.dumps({"schema": 1, "approved": approved}))

    def command(self):
        return ["accept", "--approvals", "approvals.json"]


class Merge(Scenario):
    name = "merge"

    def prepare(self, run, folder):
        for name, crop in [("t1.exr", "0,0,16,4"), ("t2.exr", "0,4,16,9")]:
            run(["render", SCENE, "-o", name, "-f", "0", *SIZE, "--crop", crop, "-q"], folder)

    def command(self):
        return ["merge", "t1.exr", "t2.exr", "-o", "whole.exr", *MEMORY]


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
    parser.add_argument("--calls", type=lambda text: text.split(","))
    options = parser.parse_args()
    program = options.program.resolve()
    # Backtraces would hide the program's own line.
    os.environ.pop("RUST_BACKTRACE", None)

    def run(arguments, folder, code=0):
        ended = subprocess.run([program, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=60)
        if ended.returncode != code:
            sys.exit(f"{arguments}: ended with {ended.returncode} without a fault: {ended.stderr}")
        return ended

    table, violations = [], []
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        for scenario in [kind() for kind in (Render, Resume, Movie, Test, Accept, Approve, Merge, Check)]:
            if options.only in (None, scenario.name):
                calls = options.calls or [*FAULTS, "memory", "limit"]
                table.extend(fail_all(scenario, program, run, place / scenario.name, calls, violations))
    print(f"{'scenario':<10} {'call':<10} {'fault':<7} {'runs':>5} {'harmless':>9}  exit codes")
    for row in table:
        print(row)
    for violation in violations:
        print("VIOLATION", violation)
    print(f"{len(violations)} violations")
    sys.exit(bool(violations))


class Calls:
    """How often a run makes each call: before its first act, and in the thread that makes most."""

    def __init__(self, log):
        self.before, self.most = collections.Counter(), collections.Counter()
        threads, has_begun = {call: collections.Counter() for call in FAULTS}, False
        for line in log.read_text(errors="replace").splitlines():
            has_begun |= FIRST_ACT in line
            found = re.match(r"(\d+)\s+(\w+)\(", line)
            if found and found[2] in FAULTS:
                threads[found[2]][found[1]] += 1
                self.before[found[2]] += not has_begun
        for call, counts in threads.items():
            self.most[call] = max(counts.values(), default=0)

    def numbers(self, call):
        return range(self.before[call] + 1, self.most[call] + 1)


def experiments(calls, strace, wanted):
    """Every fault: its call, its name, what to say of it, the words before the command, and the address space."""
    for call, error in FAULTS.items():
        if call in wanted:
            for number in calls.numbers(call):
                # The break is a result and no error.
                result = "retval=0" if call == "brk" else f"error={error}"
                fault = f"inject={call}:{result}:when={number}"
                yield call, error, number, [*strace, "-e", f"trace={call}", "-e", fault], None
    if "memory" in wanted:
        for number in calls.numbers("mmap"):
            faults = [f"inject=mmap:error=ENOMEM:when={number}+", f"inject=brk:retval=0:when={calls.before['brk'] + 1}+",
                      f"inject=mprotect:error=ENOMEM:when={calls.before['mprotect'] + 1}+"]
            injected = [word for fault in faults for word in ("-e", fault)]
            yield "memory", "ENOMEM", number, [*strace, "-e", "trace=mmap,brk,mprotect", *injected], None
    if "limit" in wanted:
        for number in LIMITS:
            yield "limit", "-v", f"{number / 2} MiB", [], number * MEGABYTE // 2


def limited(space):
    return space and (lambda: resource.setrlimit(resource.RLIMIT_AS, (space, space)))


def can_begin(program, space):
    """Whether the system can load the program into this address space, and the standard library can start it."""
    return not space or subprocess.run([program, "--version"], capture_output=True, preexec_fn=limited(space)).returncode == 0


def fail_all(scenario, program, run, place, wanted, violations):
    # Without faults.
    before, after = place / "before", place / "after"
    before.mkdir(parents=True)
    scenario.prepare(run, before)
    shutil.copytree(before, after)
    log = place / "log"
    arguments = [str(word) for word in scenario.command()]
    strace = ["strace", "-f", "-qq", "-o", str(log)]
    traced = subprocess.run([*strace, "-e", "trace=rt_sigaction," + ",".join(FAULTS), program, *arguments], cwd=after, capture_output=True,
                            text=True)
    assert traced.returncode in scenario.codes, traced
    expected, old = files(scenario, after), files(scenario, before)

    codes, harmless, names = collections.defaultdict(collections.Counter), collections.Counter(), {}
    for call, error, number, words, space in experiments(Calls(log), strace, wanted):
        if not can_begin(program, space):
            continue
        folder = place / "run"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(before, folder)
        ended = subprocess.run([*words, program, *arguments], cwd=folder, capture_output=True, text=True, timeout=120, preexec_fn=limited(space))
        names[call] = error
        codes[call][ended.returncode] += 1
        harmless[call] += ended.returncode in scenario.codes
        what = f"{scenario.name}: {call} {number} {error}: ended with {ended.returncode}: {last_line(ended.stderr)}"
        wrong = [*check_exit(scenario, call, ended), *check_files(scenario, call, ended, (old, expected), files(scenario, folder))]
        again = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True, timeout=60)
        # What was done before the fault need not be done again.
        if again.returncode not in scenario.codes | scenario.again or files(scenario, folder) != expected:
            wrong.append(f"then without a fault {again.returncode}: {last_line(again.stderr)}")
        left = [path.name for path in folder.rglob(".*") if path.suffix in (".tmp", ".lock", ".run", ".claim")]
        if left:
            wrong.append(f"{left} left after the next run")
        violations.extend(f"{what}: {reason}" for reason in wrong)

    shown = lambda call: ", ".join(f"{code}: {count}" for code, count in sorted(codes[call].items()))
    return [f"{scenario.name:<10} {call:<10} {error:<7} {codes[call].total():>5} {harmless[call]:>9}  {shown(call)}" for call, error in names.items()]


def check_exit(scenario, call, ended):
    if call == "close" and ended.returncode == 70:
        return
    if ended.returncode not in scenario.codes | FAILURES | {1}:
        yield "no such exit code"
    if "program panicked" in ended.stderr:
        yield "a panic"
    if ended.returncode not in scenario.codes and not (ended.stderr + ended.stdout).strip() and call != "write":
        yield "no message"


def check_files(scenario, call, ended, whole, left):
    old, expected = whole
    for name, content in left.items():
        if content not in (expected.get(name), old.get(name)):
            yield f"{name} is neither old nor new"
    for name in old:
        if name in expected and name not in left:
            yield f"{name} is lost"
    if ended.returncode in scenario.codes and scenario.codes_tell and call != "unlink" and left != expected:
        missing = sorted(set(expected) ^ set(left)) or [name for name in left if left[name] != expected[name]]
        yield f"success, and {missing} differ"


if __name__ == "__main__":
    main()
