#!/usr/bin/env python3
"""Runs the job files of `rayframe farm` with the engines that they are written for.

    python3 tests/oracles/farm.py target/release/rayframe [--install] [--only openjd,slurm,parallel,k8s]

- openjd: `openjd check`, then each task of the template by `openjd run`; in one of them the renderer is killed.
- slurm: a cluster of this machine. A renderer is killed, the node is lost, a job of a higher partition preempts the array, a disk is full, and tiles are
  merged by a dependent job.
- parallel: the same with GNU parallel, and a scene that changes after the job was written.
- k8s: both manifests against Kubernetes' schema, and the command of the container for each index. Needs no cluster.

The frames of each must be those of one plain run, to the byte, and no frame may be written twice: all that a killed worker
loses is one frame. Ends with 1 where anything is wrong. What is not installed is named and skipped; `--install` gets
openjd-cli and kubernetes-validate from PyPI into a temporary environment, and Slurm and GNU parallel by apt-get.
"""

import argparse
import collections
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import venv

import slurm_cluster

FRAMES = 24
SCENE = pathlib.Path(__file__).resolve().parents[2] / "scenes/demo/whitted_1980.gltf"
IMAGE = ["-r", "64x36", "--samples", "4"]
# Frames that take long enough to be interrupted.
SLOW_IMAGE = ["-r", "64x36", "--samples", "200"]


class Failure(Exception):
    pass


def run(*words, code=0, **options):
    ran = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                         errors="replace", check=False, **options)
    if code is not None and ran.returncode != code:
        raise Failure(f"{' '.join(str(word) for word in words[:4])} … ended with {ran.returncode}, not {code}:\n{ran.stdout[-3000:]}")
    return ran.stdout


class Farm:
    def __init__(self, program, folder, tools):
        self.program, self.folder, self.tools = program, folder, tools
        self.rows, self.plain = [], {}

    def frames(self, image):
        """The frames of a plain run."""
        key = " ".join(image)
        if key not in self.plain:
            folder = self.folder / f"plain-{len(self.plain)}"
            run(self.program, "render", SCENE, "-o", folder / "a.####.exr", "-f", f"0-{FRAMES - 1}", *image, "-q")
            self.plain[key] = {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
        return self.plain[key]

    def write(self, engine, name, image, *options, output="a.####.exr"):
        """Job files in a folder with a difficult name, and the folder of their outputs."""
        job, out = self.folder / f"{name} it's", self.folder / f"{name}-out"
        frames = [] if "-f" in image else ["-f", f"0-{FRAMES - 1}"]
        run(self.program, "farm", engine, SCENE, "-o", out / output, *frames, *image, "--out-dir", job, "--threads", "1",
            "--program", self.program, *options)
        return job, out

    def check(self, engine, what, out, image, log, start):
        """Compares the frames, and counts those that were written twice."""
        expected = self.frames(image)
        present = {path.name: path.read_bytes() for path in out.glob("*.exr")}
        wrong = sorted(name for name in expected if present.get(name) != expected[name])
        written = collections.Counter(re.findall(r"frame (-?\d+) \(\d+/\d+\) written", log))
        twice = sum(count - 1 for count in written.values())
        others = [path.name for path in out.iterdir() if path.name not in expected and not path.name.startswith(".")]
        self.rows.append((engine, what, f"{len(expected) - len(wrong)}/{len(expected)}", twice, time.monotonic() - start))
        if wrong or twice or others:
            raise Failure(f"{engine}, {what}: other frames {wrong}, {twice} written twice, other files {others}\n{log[-3000:]}")


def renderers(folder):
    """Processes that render into a folder."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if b"--dry-run" not in words and words[1:2] == [b"render"] and any(word.startswith(os.fsencode(folder)) for word in words):
            found.append(int(process.name))
    return sorted(found)


def kill_one(out, least_frames):
    """SIGKILL to a renderer, once some frames are there. Returns whether one was found."""
    for _ in range(1200):
        processes = renderers(out)
        if processes and len(list(out.glob("a.*.exr"))) >= least_frames:
            os.kill(processes[0], signal.SIGKILL)
            return True
        time.sleep(0.05)
    raise Failure(f"no renderer of {out} was found")


def openjd(farm):
    tool = farm.tools("openjd")
    job, out = farm.write("openjd", "openjd", SLOW_IMAGE, "--chunk", "5")
    print(run(tool, "check", job / "template.json").strip())
    start, log = time.monotonic(), ""
    step = json.loads((job / "template.json").read_text())["steps"][0]
    tasks = step["parameterSpace"]["taskParameterDefinitions"][0]["range"]
    for index, task in enumerate(tasks):
        words = [tool, "run", job / "template.json", "--step", step["name"], "-tp", f"Task={task}", "-p",
                 f"file://{job}/parameters.json"]
        with subprocess.Popen([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as session:
            if index == 1:
                kill_one(out, 6)
            said = session.communicate(timeout=300)[0]
        log += said
        if session.returncode != 0:
            raise Failure(f"openjd run, task {task}: {said[-3000:]}")
    print("\n".join(line for line in log.splitlines() if "exit code 137" in line))
    farm.check("openjd", "a renderer killed", out, SLOW_IMAGE, log, start)
    tiles(farm, "openjd", lambda job: run(tool, "run", job / "template.json", "--step", "Merge", "--run-dependencies", "-p",
                                          f"file://{job}/parameters.json"))


def tiles(farm, engine, execute):
    """A still in tiles, and one in sample ranges, merged by the job."""
    path = ["-f", "7", "-r", "64x36", "--samples", "16", "--integrator", "path"]
    for what, image, option in [("4x2 tiles", ["-f", "7", *IMAGE], ["--tiles", "4x2"]), ("3 sample ranges", path, ["--sample-ranges", "3"])]:
        start = time.monotonic()
        name = f"{engine}-{option[0][2:]}"
        job, out = farm.write(engine, name, image, *option, output="still.exr")
        execute(job)
        plain = farm.folder / f"{name}.exr"
        run(farm.program, "render", SCENE, *image, "-o", plain, "-q")
        equal = (out / "still.exr").read_bytes() == plain.read_bytes()
        farm.rows.append((engine, what, f"{int(equal)}/1", 0, time.monotonic() - start))
        if not equal:
            raise Failure(f"{engine}, {what}: another image")


def slurm(farm):
    with slurm_cluster.Cluster(farm.folder / "cluster", cpus=4) as cluster:
        logs = lambda job: "".join(path.read_text(errors="replace") for path in sorted((job / "logs").glob("*.log")))

        # A renderer is killed.
        start = time.monotonic()
        job, out = farm.write("slurm", "slurm", SLOW_IMAGE, "--chunk", "5")
        cluster.submit(job / "submit.sh")
        kill_one(out, 4)
        cluster.wait_for_the_end()
        farm.check("slurm", "a renderer killed", out, SLOW_IMAGE, logs(job), start)

        # Another partition preempts the array.
        start = time.monotonic()
        job, out = farm.write("slurm", "preempted", SLOW_IMAGE, "--chunk", "6")
        cluster.submit(job / "submit.sh")
        cluster.wait_for(lambda: len(list(out.glob("a.*.exr"))) >= 4, "the first frames")
        cluster.run("sbatch", "--partition=high", "--cpus-per-task=4", "--output=/dev/null", "--wrap=sleep 3", check=True)
        cluster.wait_for_the_end()
        farm.check("slurm", "preempted", out, SLOW_IMAGE, logs(job), start)
        ended = [line for line in logs(job).splitlines() if "Terminated" in line or "DUE TO PREEMPTION" in line]
        if not ended:
            raise Failure(f"nothing was preempted: {logs(job)}")
        print("\n".join(ended))

        # The node is lost.
        start = time.monotonic()
        job, out = farm.write("slurm", "lost", SLOW_IMAGE, "--chunk", "6")
        cluster.submit(job / "submit.sh")
        cluster.wait_for(lambda: len(list(out.glob("a.*.exr"))) >= 4, "the first frames")
        cluster.lose_node()
        cluster.wait_for_the_end()
        farm.check("slurm", "the node lost", out, SLOW_IMAGE, logs(job), start)

        # The disk is full, and becomes larger.
        start = time.monotonic()
        job, out = farm.write("slurm", "disk", IMAGE, "--chunk", "6", "--at-most", "1")
        out.mkdir()
        run("mount", "-t", "tmpfs", "-o", "size=64k", "none", out)
        try:
            cluster.submit(job / "submit.sh")
            cluster.wait_for(lambda: "No space left" in logs(job), "the full disk")
            print([line for line in logs(job).splitlines() if "No space left" in line][0])
            run("mount", "-o", "remount,size=16m", out)
            cluster.wait_for_the_end()
            farm.check("slurm", "a full disk", out, IMAGE, logs(job), start)
        finally:
            run("umount", out)

        def submit_and_wait(job):
            cluster.submit(job / "submit.sh")
            cluster.wait_for_the_end()
        tiles(farm, "slurm", submit_and_wait)

        # A scene that changes after the job was written fails without being repeated.
        job, out = farm.write("slurm", "changed", IMAGE, "--chunk", "24")
        script = job / "task.sh"
        script.write_text(re.sub(r'"render_hash":"....', '"render_hash":"xxxx', script.read_text()))
        array = cluster.submit(job / "submit.sh")
        cluster.wait_for_the_end()
        state = cluster.run("scontrol", "show", "job", f"{array}_0")
        if "ExitCode=65:0" not in state or "Restarts=0" not in state:
            raise Failure(f"a changed scene: {state}")
        farm.rows.append(("slurm", "a changed scene: 65, not repeated", "-", 0, 0))


def parallel(farm):
    environment = os.environ | {"JOBS": "2"}
    start = time.monotonic()
    job, out = farm.write("parallel", "parallel", SLOW_IMAGE, "--chunk", "5")
    with subprocess.Popen(["sh", job / "run.sh"], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as ran:
        kill_one(out, 3)
        log = ran.communicate(timeout=300)[0]
    if ran.returncode != 0:
        raise Failure(f"parallel ended with {ran.returncode}: {log[-3000:]}")
    farm.check("parallel", "a renderer killed", out, SLOW_IMAGE, log, start)
    tiles(farm, "parallel", lambda job: run("sh", job / "run.sh", env=environment))

    # A scene that changes after the job was written fails without being repeated.
    job, out = farm.write("parallel", "changed-parallel", IMAGE, "--chunk", "24")
    script = job / "task.sh"
    script.write_text(re.sub(r'"render_hash":"....', '"render_hash":"xxxx', script.read_text()))
    said = run("sh", job / "run.sh", env=environment, code=None)
    if said.count("has changed since") != 1 or "\t65\t0\t" not in (job / "joblog").read_text():
        raise Failure(f"a changed scene: {said}")
    farm.rows.append(("parallel", "a changed scene: 65, not repeated", "-", 0, 0))


def k8s(farm):
    tool = farm.tools("kubernetes-validate")
    command = lambda item: item["spec"]["template"]["spec"]["containers"][0]["command"]

    def validated(job, name):
        items = json.loads((job / name).read_text())["items"]
        for index, item in enumerate(items):
            path = job / f"item-{index}.json"
            path.write_text(json.dumps(item))
            print(run(tool, "--strict", path).strip())
            path.unlink()
        return items

    def execute(job):
        config, indexed = validated(job, "job.k8s.json")
        mounted = job / "mounted"
        mounted.mkdir()
        for name, text in config["data"].items():
            (mounted / name).write_text(text)
        local = lambda words: [word.replace("/etc/rayframe-job", ".") for word in words]
        log = ""
        for index in range(indexed["spec"]["completions"]):
            log += run(*local(command(indexed)), cwd=mounted, env=os.environ | {"JOB_COMPLETION_INDEX": str(index)})
        if (job / "merge.k8s.json").exists():
            run(*local(command(validated(job, "merge.k8s.json")[0])), cwd=mounted)
        return log

    start = time.monotonic()
    job, out = farm.write("k8s", "k8s", IMAGE, "--chunk", "5", "--claim", "projects=/projects")
    farm.check("k8s", "each index by hand", out, IMAGE, execute(job), start)
    tiles(farm, "k8s", execute)


def tools(folder, installs):
    """Finds the programs of PyPI, or gets them into a temporary environment."""
    made = []

    def find(name):
        found = shutil.which(name)
        if not found and installs:
            environment = folder / "venv"
            if not made:
                venv.create(environment, with_pip=True)
                run(environment / "bin/pip", "install", "-q", "openjd-cli", "kubernetes-validate")
                made.append(environment)
            found = environment / "bin" / name
        return found

    return find


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--install", action="store_true")
    parser.add_argument("--only", default="openjd,slurm,parallel,k8s")
    options = parser.parse_args()
    if options.install and os.geteuid() == 0 and (slurm_cluster.missing() or not shutil.which("parallel")):
        run("apt-get", "install", "-y", "slurmctld", "slurmd", "slurm-client", "munge", "parallel")

    is_wrong = False
    with tempfile.TemporaryDirectory(prefix="rayframe-farm-") as folder:
        farm = Farm(options.program.resolve(), pathlib.Path(folder), tools(pathlib.Path(folder), options.install))
        lacks = {
            "openjd": lambda: "" if farm.tools("openjd") else "openjd (PyPI: openjd-cli)",
            "slurm": slurm_cluster.missing,
            "parallel": lambda: "" if shutil.which("parallel") else "parallel",
            "k8s": lambda: "" if farm.tools("kubernetes-validate") else "kubernetes-validate (PyPI)",
        }
        for engine in options.only.split(","):
            lacking = lacks[engine]()
            if lacking:
                print(f"skipped: {engine}: {lacking} is missing; --install gets it")
                continue
            try:
                globals()[engine](farm)
            except (Failure, RuntimeError) as failure:
                is_wrong = True
                print(f"FAIL {failure}")
        print(f"\n{'engine':10} {'what':36} {'equal':>7} {'twice':>6} {'seconds':>8}")
        for engine, what, equal, twice, seconds in farm.rows:
            print(f"{engine:10} {what:36} {equal:>7} {twice:>6} {seconds:>8.1f}")
    return int(is_wrong)


if __name__ == "__main__":
    sys.exit(main())
