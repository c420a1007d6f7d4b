#!/usr/bin/env python3
"""Renders in control groups with a memory limit, where the system lets this program make them.

    sudo python3 tests/oracles/memory_cgroup.py RAYFRAME

Checks that `max_memory` is four fifths of the group's limit, of this group or of one around it; that what is accepted under the default
limit ends without being killed; and that a run which the system kills (exit code 137) leaves whole frames, which `--resume` completes to the
bytes of an undisturbed run. Works with versions 1 and 2 of control groups. Says why and ends with 0 where no group can be made; the unit
tests of `src/shot/memory_limit.rs` read copies of the system's files there. Exit code 1: a check fails.
"""

import contextlib
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/demo/whitted_1980.gltf"
MOUNT = pathlib.Path("/sys/fs/cgroup")
# Frames with previews are not rendered in bands, so that their size is limited.
WHOLE = ["--preview", "png"]
LIMIT = 200_000_000
# A process that takes this much beside a render exceeds the limit; alone it does not.
BALLAST = 190_000_000
FRAMES = "0-11"


class Group:
    """A control group of version 1 or 2 with a memory limit, or without one."""

    def __init__(self, path, limit=None):
        self.path = path
        self.path.mkdir()
        if limit:
            (path / ("memory.max" if is_version_2() else "memory.limit_in_bytes")).write_text(str(limit))

    def command(self, command):
        """A command that joins the group first."""
        join = 'echo $$ > "$0" && exec "$@"'
        return ["sh", "-c", join, str(self.path / "cgroup.procs"), *map(str, command)]

    def run(self, *command):
        return subprocess.run(self.command(command), capture_output=True, text=True)

    def remove(self):
        for _ in range(50):
            with contextlib.suppress(OSError):
                return self.path.rmdir()
            time.sleep(0.1)


def is_version_2():
    return (MOUNT / "cgroup.controllers").exists()


def made_groups():
    """A limited group and one inside it, or the reason why there are none."""
    parent = MOUNT if is_version_2() else MOUNT / "memory"
    name = f"rayframe-test-{os.getpid()}"
    try:
        if is_version_2() and "memory" not in (MOUNT / "cgroup.subtree_control").read_text():
            return None, f"{MOUNT}/cgroup.subtree_control does not pass on `memory`"
        outer = Group(parent / name, LIMIT)
        if is_version_2():
            # Processes live in leaves only.
            (outer.path / "cgroup.subtree_control").write_text("+memory")
        return (outer, Group(outer.path / "inner")), None
    except OSError as error:
        return None, f"{error}; run this as root"


def check(is_true, text):
    print(f"{'ok    ' if is_true else 'FAILED'}  {text}", flush=True)
    return is_true


def follows_the_group(rayframe, group, folder):
    """An image that is much too large names the limit in its refusal."""
    refused = group.run(rayframe, "render", SCENE, "-f", "0", "-r", "20000x20000", *WHOLE, "-o", folder / "a.exr", "--dry-run")
    expected = f"more than the limit of {LIMIT // 5 * 4 / 1e6:.1f} MB"
    # Limits are whole pages.
    stated = re.search(r"more than the limit of ([\d.]+) MB", refused.stderr)
    is_near = stated and abs(float(stated[1]) - LIMIT * 0.8e-6) < 0.1
    return check(refused.returncode == 77 and is_near, f"the default limit: {expected}; {refused.stderr.strip().splitlines()[-1:]}")


def accepted_is_not_killed(rayframe, group, folder):
    """The largest image that the default limit accepts is rendered without a kill."""
    def command(rows):
        return [rayframe, "render", SCENE, "-f", "0-1", "-r", f"{2 * rows}x{rows}", "--samples", "1", "-q", *WHOLE, "-o", folder / "b.##.exr", "--overwrite"]

    low, high = 64, 8192
    while high - low > 16:
        middle = (low + high) // 2
        accepted = group.run(*command(middle), "--dry-run").returncode == 0
        low, high = (middle, high) if accepted else (low, middle)
    ended = group.run(*command(low))
    return check(ended.returncode == 0, f"{2 * low}x{low} is the largest image that is accepted; exit code {ended.returncode}")


def resumes_after_a_kill(rayframe, group, folder):
    """Another process of the group takes the memory, and the system kills the render."""
    render = [rayframe, "render", SCENE, "-f", FRAMES, "-r", "640x360", "--samples", "4", "-q"]
    subprocess.run([*map(str, render), "-o", str(folder / "whole.##.exr")], check=True)
    pattern = folder / "killed.##.exr"
    running = subprocess.Popen(["sh", "-c", 'echo 1000 > /proc/self/oom_score_adj && exec "$@"', "sh", *group.command([*render, "-o", pattern])])
    while running.poll() is None and len(list(folder.glob("killed.*.exr"))) < 2:
        time.sleep(0.005)
    fill = f"held = bytearray({BALLAST}); held[::4096] = b'x' * len(held[::4096]); print(flush=True); import time; time.sleep(60)"
    ballast = subprocess.Popen(group.command([sys.executable, "-c", fill]), stdout=subprocess.PIPE)
    code = running.wait()
    ballast.kill()
    ballast.wait()
    frames = sorted(folder.glob("killed.*.exr"))
    is_killed = check(code == -signal.SIGKILL, f"the system ended the render with signal {-code}: exit code {128 - code}")
    whole = subprocess.run([rayframe, "check", *frames], capture_output=True, text=True)
    is_whole = check(2 <= len(frames) < 12 and whole.returncode == 0, f"{len(frames)} frames are there, all whole: {whole.stderr.strip()}")
    resumed = group.run(*render, "-o", pattern, "--resume")
    is_resumed = check(resumed.returncode == 0, f"`--resume` goes on: exit code {resumed.returncode} {resumed.stderr.strip()}")
    pairs = [(file, folder / file.name.replace("whole", "killed")) for file in folder.glob("whole.*.exr")]
    same = sum(ours.exists() and file.read_bytes() == ours.read_bytes() for file, ours in pairs)
    is_clean = not list(folder.glob(".*.tmp"))
    is_same = check(same == len(pairs) and is_clean, f"{same} of {len(pairs)} frames are those of an undisturbed run, no temporary files are left")
    return is_killed and is_whole and is_resumed and is_same


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    rayframe = pathlib.Path(sys.argv[1]).resolve()
    groups, why = made_groups()
    if groups is None:
        print(f"skipped: no control group can be made here: {why}")
        return 0
    outer, inner = groups
    try:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            # In version 2 the limited group itself holds no processes.
            results = [follows_the_group(rayframe, inner, folder)]
            results += [] if is_version_2() else [follows_the_group(rayframe, outer, folder)]
            results += [accepted_is_not_killed(rayframe, inner, folder), resumes_after_a_kill(rayframe, inner, folder)]
    finally:
        inner.remove()
        outer.remove()
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
