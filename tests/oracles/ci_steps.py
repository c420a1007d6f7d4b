#!/usr/bin/env python3
"""End-to-end test of action.yml, ci/gitlab.yml and the workflows in docs/suites.md, without GitHub, GitLab or containers.

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install pyyaml
    /tmp/venv/bin/python tests/oracles/ci_steps.py target/release/rayframe [--keep DIR]

Every shell step runs in bash as on the runner, GitLab's also in sh. Checkouts are clones of a repository with three scenes; caches and
artifacts are copies of folders; `cargo install` copies the given program, so that building is not tested. The scenarios:

- first: there are no references, the test fails, and the images of its artifact are accepted,
- second and third: the test passes, then nothing is rendered,
- edited: a scene changes beyond the limits, then within them,
- shards: two parts of the suite, each with its report, are merged,
- inputs: settings that are wrong, or hold commands, and no caches (GitHub only).

A table of the steps with their outcomes is printed. The exit code is 1 where an expectation does not hold.
"""

import argparse
import copy
import json
import pathlib
import shutil
import sys
import tempfile

import yaml

from ci_machine import Failure, Machine, Table, yaml_blocks
from github_runner import GitHub
from gitlab_runner import GitLab

TOP = pathlib.Path(__file__).resolve().parents[2]
# Names of the shots, which belong to different shards, and their scenes.
SHOTS = {"diffuse": "material/diffuse.gltf", "mirror": "material/mirror.gltf", "props/instancing": "geometry/instancing.gltf"}


class Developer:
    """A clone of the project with the scenes, where no build server is."""

    def __init__(self, machine, program, folder):
        self.machine, self.program, self.folder = machine, pathlib.Path(program).resolve(), folder
        self.suite = folder / "renders"
        self.suite.mkdir(parents=True)
        self.run(program, "test", "--init", "--suite", "renders")
        for name, scene in SHOTS.items():
            target = self.suite / f"{name}.gltf"
            target.parent.mkdir(exist_ok=True)
            shutil.copyfile(TOP / "scenes" / scene, target)
        self.run("git", "init", "-q", "-b", "main")
        self.commit("Add scenes")

    def run(self, *words):
        person = {f"GIT_{role}_{key}": value for role in ("AUTHOR", "COMMITTER")
                  for key, value in (("NAME", "A developer"), ("EMAIL", "developer@example.com"))}
        code, said = self.machine.run(words, self.folder, person)
        if code:
            raise Failure(f"{' '.join(map(str, words))}: exit code {code}\n{said}")
        return said

    def commit(self, message):
        self.run("git", "add", "-A")
        self.run("git", "commit", "-q", "-m", message)

    def accept(self, report, *more):
        """Accepts the images of a report, commits them, and returns their number."""
        said = self.run(self.program, "accept", "--from", report, "--suite", "renders", *more)
        self.commit("Accept images")
        return sum(line.startswith(("added", "replaced")) for line in said.splitlines())

    def scale_colours(self, name, factor):
        """Multiplies the base colours of a scene."""
        file = self.suite / f"{name}.gltf"
        scene = json.loads(file.read_text())
        for material in scene["materials"]:
            colour = material.get("pbrMetallicRoughness", {}).get("baseColorFactor", [1, 1, 1, 1])
            material.setdefault("pbrMetallicRoughness", {})["baseColorFactor"] = [min(1, factor * c) for c in colour[:3]] + colour[3:]
        file.write_text(json.dumps(scene))
        self.commit(f"Change {name}")


def result_of(report):
    return json.loads((report / "result.json").read_text())


def cached(report):
    """The names of the shots in a report that were not rendered."""
    return {shot["name"] for shot in result_of(report)["shots"] if shot["cached"]}


def images(report):
    """The names of the shots of which a report has images. The name of a view or clip follows that of a shot after @."""
    return {file.relative_to(report / "images").with_suffix("").as_posix().split("@")[0] for file in report.glob("images/**/*.exr")}


def with_inputs(workflow, job, **inputs):
    """The workflow, with inputs of its action replaced."""
    workflow = copy.deepcopy(workflow)
    workflow["jobs"][job]["steps"][-1]["with"].update({name.replace("_", "-"): value for name, value in inputs.items()})
    return workflow


def github_life(github, developer, workflow):
    """The scenarios of one job: first, second, third and edited."""
    expect = github.table.expect
    run = github.run("first", workflow)
    job, report = run.jobs[0], run.artifacts.get("rayframe-report")
    expect("first", "the job fails, by the exit code of the test", not job.passes and job.outcomes["Test"].endswith("code 1"))
    expect("first", "the artifact has the page, the result and all images",
           images(report) == set(SHOTS) and (report / "index.html").exists())
    expect("first", "each shot has an annotation", set(job.annotations()) == {("error", f"renders/{name}.gltf") for name in SHOTS})
    expect("first", "the summary tells why", "there is no reference" in job.summary)
    expect("first", "the output is the folder of the report", job.outputs == {"report": "renders/report"})
    expect("first", "images are accepted from the artifact", developer.accept(report) == len(SHOTS))

    run = github.run("second", workflow)
    expect("second", "the job passes, and every shot was rendered", run.passes() and not cached(run.artifacts["rayframe-report"]))
    expect("second", "the program came from the cache", len(github.machine.installs()) == 1)

    run = github.run("third", workflow)
    expect("third", "the job passes, and no shot was rendered", run.passes() and cached(run.artifacts["rayframe-report"]) == set(SHOTS))

    developer.scale_colours("props/instancing", 0.5)
    run = github.run("edited", workflow)
    job, report = run.jobs[0], run.artifacts["rayframe-report"]
    expect("edited", "the job fails, and only that shot was rendered",
           job.outcomes["Test"].endswith("code 1") and cached(report) == set(SHOTS) - {"props/instancing"})
    expect("edited", "the verdicts of the others are kept", job.outcomes["Save verdicts"] == "saved")
    expect("edited", "the shot has an annotation", job.annotations() == [("error", "renders/props/instancing.gltf")])
    expect("edited", "the summary names the shot with its cause", "props/instancing" in job.summary and "material" in job.summary)
    expect("edited", "its image is accepted", developer.accept(report) == 1)

    developer.scale_colours("props/instancing", 0.99)
    run = github.run("changed", workflow)
    job, report = run.jobs[0], run.artifacts["rayframe-report"]
    expect("changed", "the job passes with a warning", run.passes() and job.annotations() == [("warning", "renders/props/instancing.gltf")])
    run = github.run("changed", with_inputs(workflow, "renders", fail_on="changed"))
    expect("changed", "fail-on: changed fails", run.jobs[0].outcomes["Test"].endswith("code 1"))
    expect("changed", "its image is accepted", developer.accept(report, "--changed") == 1)


def github_shards(github, developer, workflow):
    """The workflow with a matrix of shards and a merging job."""
    expect = github.table.expect
    workflow["jobs"]["shards"]["strategy"]["matrix"]["part"] = [1, 2]
    developer.scale_colours("mirror", 0.3)
    run = github.run("shards", workflow)
    parts = [result_of(run.artifacts[f"rayframe-report-{part}-of-2"]) for part in (1, 2)]
    shots = [{shot["name"] for shot in part["shots"]} for part in parts]
    expect("shards", "each shot belongs to one shard", all(shots) and not shots[0] & shots[1] and shots[0] | shots[1] == set(SHOTS))
    expect("shards", "only the shard of the edited shot fails",
           [run.job(f"shards {part}").passes for part in (1, 2)] == ["mirror" not in part for part in shots])
    merge, report = run.job("renders"), run.artifacts["rayframe-report"]
    expect("shards", "the merging job fails, by the exit code of the test", merge.outcomes["Test"].endswith("code 1"))
    expect("shards", "the merged report has all shots, and the image",
           {shot["name"] for shot in result_of(report)["shots"]} == set(SHOTS) and images(report) == {"mirror"})
    expect("shards", "the merged summary has the failure, and no annotation is repeated",
           "mirror" in merge.summary and not merge.annotations())

    partial = copy.deepcopy(workflow)
    partial["jobs"]["renders"]["steps"][1]["with"]["pattern"] = "rayframe-report-1-*"
    run = github.run("shard missing", partial)
    expect("shard missing", "the merging job refuses", run.job("renders").outcomes["Test"].endswith("code 2"))
    partial["jobs"]["renders"]["steps"][1]["with"]["pattern"] = "none"
    run = github.run("shards missing", partial)
    expect("shards missing", "the merging job refuses", not run.job("renders").passes)

    expect("shards", "the image is accepted from the merged report", developer.accept(report) == 1)
    run = github.run("shards accepted", workflow)
    expect("shards accepted", "all jobs pass", run.passes())
    run = github.run("shards unchanged", workflow)
    expect("shards unchanged", "no shot was rendered", run.passes() and cached(run.artifacts["rayframe-report"]) == set(SHOTS))


def github_inputs(github, workflow):
    """Inputs that are wrong or hold commands, other forms of the suite, and new sources of the program."""
    expect = github.table.expect
    marker = github.machine.root / "injected"
    substitution, end_of_string = f"$(touch {marker})", f"'\"; touch {marker}; #"
    commands = [(name, substitution) for name in ("suite", "args", "fail_on", "shard", "merge", "report", "cache")]
    for name, command in [*commands, ("suite", end_of_string), ("args", end_of_string)]:
        run = github.run(f"command in {name}", with_inputs(workflow, "renders", **{name: command}))
        expect(f"command in {name}", "it is not run, and the job fails", not marker.exists() and not run.passes())
    for name, value in (("shard", "0/2"), ("shard", "1/2\nx=1"), ("suite", ""), ("suite", ".\nreport=/"), ("cache", "yes")):
        run = github.run("wrong input", with_inputs(workflow, "renders", **{name: value}))
        expect("wrong input", f"{name} {value!r} is refused, and the program is not started",
               run.jobs[0].outcomes["Test"] == "skipped" and not run.artifacts)
    run = github.run("suite file", with_inputs(workflow, "renders", suite="renders/suite.toml", args="* --slowest 2", report="file"))
    expect("suite file", "a * is no file name", r" \* --slowest 2 " in run.jobs[0].log)
    run = github.run("suite file", with_inputs(workflow, "renders", suite="renders/suite.toml", args=" mirror  --slowest 2 ", report="file"))
    expect("suite file", "arguments are passed, and the artifact has its name",
           run.passes() and [shot["name"] for shot in result_of(run.artifacts["file"])["shots"]] == ["mirror"])

    installs, caches = len(github.machine.installs()), len(github.caches)
    uncached = with_inputs(workflow, "renders", cache="false")
    uncached["jobs"]["renders"]["steps"].append({"name": "Later step", "shell": "bash", "run": "rayframe --version"})
    run = github.run("no cache", uncached)
    expect("no cache", "everything is built and rendered, and nothing is kept",
           run.passes() and not cached(run.artifacts["rayframe-report"])
           and "--no-cache" in run.jobs[0].log and len(github.machine.installs()) == installs + 1 and len(github.caches) == caches)
    expect("no cache", "later steps find the program", run.jobs[0].outcomes["Later step"] == "success")
    with open(github.action / "src/lib.rs", "a") as source:
        source.write("// Another revision.\n")
    run = github.run("new revision", workflow)
    expect("new revision", "the program is built again", run.passes() and len(github.machine.installs()) == installs + 2)


def gitlab_life(gitlab, developer, pipeline):
    """All scenarios in short, on a project whose references were removed."""
    expect = gitlab.table.expect
    shutil.rmtree(developer.suite / "references")
    developer.commit("Remove references")
    single = {"variables": pipeline["variables"], "renders": {"extends": ".rayframe-test"}}
    installs = len(gitlab.machine.installs())

    job = gitlab.run("first", single)[0]
    report = job.artifact / "rayframe-report"
    expect("first", "the job fails, and the artifact has all images", not job.passes and images(report) == set(SHOTS))
    expect("first", "each shot is in JUnit and in Code Quality", job.reports["junit"].count("<failure") == len(SHOTS)
           and {issue["location"]["path"] for issue in json.loads(job.reports["codequality"])} == {f"renders/{name}.gltf" for name in SHOTS})
    expect("first", "images are accepted from the artifact", developer.accept(report) == len(SHOTS))
    job = gitlab.run("second", single)[0]
    expect("second", "the job passes, and every shot was rendered", job.passes and not cached(job.artifact / "rayframe-report"))
    job = gitlab.run("third", single, "sh")[0]
    expect("third", "the job passes, and no shot was rendered", job.passes and cached(job.artifact / "rayframe-report") == set(SHOTS))
    expect("third", "the program was built once", len(gitlab.machine.installs()) == installs + 1)

    developer.scale_colours("mirror", 2)
    job = gitlab.run("edited", single)[0]
    expect("edited", "the job fails, and Code Quality names the shot",
           not job.passes and [issue["location"]["path"] for issue in json.loads(job.reports["codequality"])] == ["renders/mirror.gltf"])

    pipeline["shards"]["parallel"] = 2
    for shell in ("bash", "sh"):
        jobs = gitlab.run(f"shards in {shell}", pipeline, shell)
        report = jobs[-1].artifact / "rayframe-report"
        expect(f"shards in {shell}", "one shard and the merging job fail", sorted(job.passes for job in jobs) == [False, False, True]
               and not jobs[-1].passes)
        expect(f"shards in {shell}", "the merged report has all shots, and the image",
               {shot["name"] for shot in result_of(report)["shots"]} == set(SHOTS) and images(report) == {"mirror"})
    expect("shards", "the image is accepted from the merged report", developer.accept(report) == 1)
    jobs = gitlab.run("shards accepted", pipeline)
    expect("shards accepted", "all jobs pass", all(job.passes for job in jobs))
    job = gitlab.run("no revision", {**single, "variables": {**pipeline["variables"], "RAYFRAME_REVISION": ""}})[0]
    expect("no revision", "the job fails, and names the variable", not job.passes and "RAYFRAME_REVISION" in job.log)


def all_scenarios(root, program, table):
    machine = Machine(root, program)
    action = root / "actions/OWNER/rayframe/REVISION"
    shutil.copytree(TOP / "src", action / "src")
    for name in ("action.yml", "Cargo.toml", "Cargo.lock"):
        shutil.copyfile(TOP / name, action / name)
    developer = Developer(machine, program, root / "project")
    guide = (TOP / "docs/suites.md").read_text()

    single, sharded = [yaml.safe_load(block) for block in yaml_blocks(guide, "GitHub Actions")]
    github = GitHub(machine, action, developer.folder, table.of_service("GitHub"))
    github_life(github, developer, single)
    github_shards(github, developer, sharded)
    github_inputs(github, single)
    gitlab = GitLab(machine, TOP / "ci/gitlab.yml", developer.folder, table.of_service("GitLab"))
    gitlab_life(gitlab, developer, yaml.safe_load(yaml_blocks(guide, "GitLab")[0]))
    installs = machine.installs()
    table.expect("all", "cargo installs from the action's folder, or at the revision", all(
        f"install --locked --path {action} --root " in line
        or "install --locked --force --git https://HOST/OWNER/rayframe.git --rev REVISION --root " in line for line in installs))


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("rayframe")
    arguments.add_argument("--keep", type=pathlib.Path, help="an empty folder for all files, which are kept")
    options = arguments.parse_args()
    table = Table()
    with tempfile.TemporaryDirectory() as folder:
        try:
            all_scenarios(options.keep.resolve() if options.keep else pathlib.Path(folder), options.rayframe, table)
        finally:
            print(table.text())
    print(f"{table.failures} expectations do not hold" if table.failures else "all expectations hold")
    return 1 if table.failures else 0


if __name__ == "__main__":
    sys.exit(main())
