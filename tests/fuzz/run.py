#!/usr/bin/env python3
"""Builds the fuzz targets and runs them for a time each, with coverage feedback.

    tests/fuzz/run.py                      all targets, 60 seconds each
    tests/fuzz/run.py --seconds 600 gltf   one target, ten minutes

Prints a table of executions, coverage and finds. Inputs that reach new code are kept in target/fuzz/corpus, where the next run
continues. A find is stored in tests/fuzz/finds/TARGET, where `cargo test --test fuzz_finds` replays it; the exit code is then 1.
Needs a C++ compiler, and no other toolchain than the stable one.
"""

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FINDS = ROOT / "tests/fuzz/finds"
# Longest time of one input, seconds, and longest input, bytes.
TIMEOUT, MAX_BYTES = 5, 65536
# Finds of one target after which it ends.
MAX_FINDS = 5
FLAGS = ["level=4", "inline-8bit-counters", "pc-table", "trace-compares"]


def host():
    version = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout
    return re.search(r"host: (\S+)", version).group(1)


def build(target_dir):
    """Builds the program, instrumented, and the writer of seeds; returns the path of the program."""
    # With --target, build scripts and macros are not instrumented.
    flags = ["-Cpasses=sancov-module"] + [f"-Cllvm-args=-sanitizer-coverage-{flag}" for flag in FLAGS]
    environment = {**os.environ, "RUSTFLAGS": " ".join(flags), "CARGO_TARGET_DIR": str(target_dir / "instrumented")}
    command = ["cargo", "build", "--locked", "-p", "fuzz_targets", "--features", "libfuzzer", "--bin", "fuzz"]
    triple = host()
    subprocess.run(command + ["--profile", "fuzz", "--target", triple], check=True, cwd=ROOT, env=environment)
    return target_dir / "instrumented" / triple / "fuzz" / "fuzz"


def write_seeds(folder):
    command = ["cargo", "run", "--quiet", "--locked", "-p", "fuzz_targets", "--bin", "fuzz_seeds", "--", str(folder)]
    return subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.PIPE, text=True).stdout.split()


def fuzz(program, target, folders, seconds):
    """One run of a target until a find or the end of its time. Returns what libFuzzer printed and the inputs that it kept as finds."""
    corpus, seeds, artifacts = folders
    with tempfile.TemporaryDirectory(prefix="rayframe-fuzz-") as scratch:
        environment = {**os.environ, "FUZZ_TARGET": target, "RAYON_NUM_THREADS": "1", "TMPDIR": scratch}
        command = [str(program), f"-max_total_time={seconds}", f"-timeout={TIMEOUT}", f"-max_len={MAX_BYTES}", "-rss_limit_mb=2048",
                   "-print_final_stats=1", "-len_control=20", f"-dict={seeds.parent / target}.dict", f"-artifact_prefix={artifacts}/",
                   str(corpus), str(seeds)]
        before = set(artifacts.iterdir())
        run = subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, errors="replace")
    found = sorted(set(artifacts.iterdir()) - before)
    return run.stderr, [path for path in found if path.name.startswith(("crash-", "timeout-", "oom-"))]


def minimized(program, target, find, artifacts):
    """A smaller input that fails, too."""
    smaller = artifacts / f"smaller-{find.name}"
    environment = {**os.environ, "FUZZ_TARGET": target, "RAYON_NUM_THREADS": "1"}
    command = [str(program), "-minimize_crash=1", "-max_total_time=30", f"-timeout={TIMEOUT}", f"-exact_artifact_path={smaller}", str(find)]
    try:
        subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=60)
    except subprocess.TimeoutExpired:
        pass
    return smaller if smaller.exists() else find


def last(pattern, text):
    found = re.findall(pattern, text)
    return int(found[-1]) if found else 0


def run_target(program, target, folder, seconds):
    """All runs of a target; returns a row of the table."""
    seeds, corpus, artifacts = folder / "seeds" / target, folder / "corpus" / target, folder / "artifacts" / target
    for path in [corpus, artifacts]:
        path.mkdir(parents=True, exist_ok=True)
    # Finds of earlier runs are inputs, too. Those of this run would only be found again.
    for find in (FINDS / target).glob("*"):
        shutil.copy(find, corpus)
    row = {"target": target, "executions": 0, "edges": 0, "features": 0, "inputs": 0, "MB": 0, "finds": 0}
    end = time.monotonic() + seconds
    while (left := int(end - time.monotonic())) > 0 and row["finds"] < MAX_FINDS:
        text, finds = fuzz(program, target, (corpus, seeds, artifacts), left)
        row["executions"] += last(r"number_of_executed_units: (\d+)", text) or last(r"#(\d+)", text)
        for key, pattern in [("edges", r" cov: (\d+)"), ("features", r" ft: (\d+)"), ("MB", r" rss: (\d+)Mb"), ("inputs", r" corp: (\d+)")]:
            row[key] = max(row[key], last(pattern, text))
        (folder / f"{target}.log").write_text(text)
        for find in finds:
            row["finds"] += 1
            content = minimized(program, target, find, artifacts).read_bytes()
            stored = FINDS / target / hashlib.sha256(content).hexdigest()[:12]
            stored.parent.mkdir(parents=True, exist_ok=True)
            stored.write_bytes(content)
            why = re.findall(r"^(?:find: .*|==\d+== ERROR: .*|memory allocation .*)$", text, re.MULTILINE)
            print(f"{target}: {stored.relative_to(ROOT)}: {why[0] if why else 'no message'}", flush=True)
        if not finds and "DONE" not in text and "Done" not in text:
            raise SystemExit(f"{target}: libFuzzer ended early:\n{text[-2000:]}")
    return row


def print_table(rows):
    total = {key: sum(row[key] for row in rows) for key in ["executions", "finds"]}
    print("\n| target | executions | edges | features | inputs kept | peak MB | finds |\n|---|--:|--:|--:|--:|--:|--:|")
    for row in rows:
        print("| {target} | {executions:,} | {edges:,} | {features:,} | {inputs:,} | {MB} | {finds} |".format(**row))
    print("| all | {executions:,} | | | | | {finds} |".format(**total))
    return total["finds"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help="all by default")
    parser.add_argument("--seconds", type=int, default=60, help="time of each target")
    parser.add_argument("--folder", type=lambda path: Path(path).resolve(), default=ROOT / "target/fuzz", help="corpus, logs and build (default target/fuzz)")
    arguments = parser.parse_args()
    names = write_seeds(arguments.folder / "seeds")
    if unknown := set(arguments.targets) - set(names):
        parser.error(f"no target {', '.join(sorted(unknown))}; the targets are {', '.join(names)}")
    program = build(arguments.folder)
    rows = [run_target(program, name, arguments.folder, arguments.seconds) for name in arguments.targets or names]
    sys.exit(1 if print_table(rows) else 0)


if __name__ == "__main__":
    main()
