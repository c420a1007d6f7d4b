"""A runner of GitHub workflows without GitHub: checkout, caches and artifacts are copies of folders, and shell steps run in bash.

It knows what action.yml and the workflows of docs/suites.md use. Other keys, actions, inputs and expressions are errors.
"""

import fnmatch
import pathlib
import re
import shutil
from dataclasses import dataclass, field

import yaml

from ci_machine import Failure, clone, copy, fresh
from github_expressions import condition, filled

RAYFRAME = "OWNER/rayframe@REVISION"
# The inputs of actions, of those that are in use here, and their outputs.
ACTIONS = {
    "actions/checkout@v5": ({"lfs"}, ()),
    "actions/cache/restore@v5": ({"path", "key", "restore-keys"}, ("cache-hit",)),
    "actions/cache/save@v5": ({"path", "key"}, ()),
    "actions/upload-artifact@v6": ({"name", "path", "if-no-files-found"}, ()),
    "actions/download-artifact@v7": ({"pattern", "path"}, ()),
}
JOB_KEYS = {"runs-on", "strategy", "needs", "if", "steps"}
STEP_KEYS = {"name", "id", "if", "uses", "with", "run", "shell", "env"}


@dataclass
class Job:
    """A job that ran: its outcome, the outcomes of its steps by name, the output and the summary."""

    name: str
    passes: bool = True
    outcomes: dict = field(default_factory=dict)
    log: str = ""
    summary: str = ""
    outputs: dict = field(default_factory=dict)

    def annotations(self):
        """Kind and file of each annotation in the output."""
        return re.findall(r"^::(error|warning) file=([^,]*),", self.log, flags=re.MULTILINE)


@dataclass
class Run:
    """A run of a workflow: its jobs, and the folders of its artifacts by name."""

    number: int
    jobs: list = field(default_factory=list)
    artifacts: dict = field(default_factory=dict)

    def job(self, name):
        return next(job for job in self.jobs if job.name == name)

    def passes(self):
        return all(job.passes for job in self.jobs)


def only(keys, known, of):
    unknown = set(keys) - set(known)
    if unknown:
        raise Failure(f"{of}: unknown {', '.join(sorted(unknown))}")


class GitHub:
    """The service: workflows, caches of a repository, and one runner."""

    def __init__(self, machine, action, repository, table):
        self.machine, self.action, self.repository, self.table = machine, pathlib.Path(action), repository, table
        self.workspace = machine.root / "github/work/renders"
        self.temp = machine.root / "github/temp"
        self.caches, self.count = [], 0

    def run(self, scenario, workflow):
        """Runs all jobs of a workflow, one after the other."""
        self.count += 1
        run = Run(self.count)
        for name, job in workflow["jobs"].items():
            only(job, JOB_KEYS, f"job {name}")
            needs = job.get("needs", [])
            needs = [needs] if isinstance(needs, str) else needs
            has_failed = any(not earlier.passes for earlier in run.jobs if earlier.name.split(" ")[0] in needs)
            if not condition(job.get("if"), {}, has_failed):
                self.table.add(scenario, name, "", "job skipped")
                continue
            self.matrix(scenario, run, name, job)
        return run

    def matrix(self, scenario, run, name, job):
        strategy = job.get("strategy", {})
        only(strategy, {"fail-fast", "matrix"}, f"strategy of {name}")
        dimensions = strategy.get("matrix", {})
        if len(dimensions) > 1:
            raise Failure(f"matrix of {name}: has more than one dimension")
        key, values = next(iter(dimensions.items()), (None, [None]))
        for value in values:
            contexts = {"github": {"run_id": str(1000 + run.number), "run_attempt": "1"},
                        "strategy": {"job-total": str(len(values))}}
            if key:
                contexts["matrix"] = {key: value}
            running = RunningJob(self, scenario, run, Job(f"{name} {value}" if key else name))
            running.steps(job["steps"], contexts)
            run.jobs.append(running.job)
            if not running.job.passes and strategy.get("fail-fast", True):
                break


class RunningJob:
    """A job on the runner, whose workspace and temporary folder are empty at first."""

    def __init__(self, service, scenario, run, job):
        self.service, self.machine, self.scenario, self.run, self.job = service, service.machine, scenario, run, job
        self.workspace, self.temp = fresh(service.workspace), fresh(service.temp)
        self.path = []

    def steps(self, steps, contexts):
        """Runs the steps of a job or of a composite action; afterwards `contexts` has their outputs."""
        contexts["steps"], has_failed = {}, False
        for step in steps:
            only(step, STEP_KEYS, "step")
            name = step.get("name", step.get("uses", "run"))
            outputs = {output: "" for output in ACTIONS.get(step.get("uses"), ((), ()))[1]}
            outcome, words = "skipped", "skipped"
            if condition(step.get("if"), contexts, has_failed):
                passes, words = self.step(step, contexts, outputs)
                outcome = "success" if passes else "failure"
            has_failed |= outcome == "failure"
            if step.get("uses") != RAYFRAME:
                self.service.table.add(self.scenario, self.job.name, name, words)
            self.job.outcomes[name] = words
            if "id" in step:
                contexts["steps"][step["id"]] = {"outcome": outcome, "outputs": outputs}
        self.job.passes &= not has_failed
        return not has_failed

    def step(self, step, contexts, outputs):
        """Whether the step succeeds, and words for the table."""
        if "run" in step:
            return self.shell(step, contexts, outputs)
        inputs = {name: filled(value, contexts) for name, value in step.get("with", {}).items()}
        if step["uses"] == RAYFRAME:
            return self.rayframe(inputs, contexts)
        if step["uses"] not in ACTIONS:
            raise Failure(f"unknown action {step['uses']}")
        only(inputs, ACTIONS[step["uses"]][0], step["uses"])
        action = step["uses"].split("@")[0].replace("actions/", "").replace("/", "_").replace("-", "_")
        return getattr(self, action)(inputs, outputs)

    def rayframe(self, inputs, contexts):
        action = yaml.safe_load((self.service.action / "action.yml").read_text())
        only(inputs, action["inputs"], "action.yml")
        contexts = {
            "inputs": {name: inputs.get(name, declared["default"]) for name, declared in action["inputs"].items()},
            "github": contexts["github"],
        }
        passes = self.steps(action["runs"]["steps"], contexts)
        if contexts["steps"]["names"]["outcome"] == "success":
            self.job.outputs = {name: filled(output["value"], contexts) for name, output in action["outputs"].items()}
        return passes, "success" if passes else "failure"

    def shell(self, step, contexts, outputs):
        if step.get("shell") != "bash" or "${{" in step["run"]:
            raise Failure(f"{step.get('name')}: scripts are for bash and have no expressions")
        script = self.temp / "script.sh"
        files = {name: self.temp / name for name in ("GITHUB_OUTPUT", "GITHUB_PATH", "GITHUB_ENV", "GITHUB_STEP_SUMMARY")}
        for file in files.values():
            file.write_text("")
        script.write_text(step["run"])
        env = {
            "CI": "true", "GITHUB_ACTIONS": "true", "RUNNER_OS": "Linux", "RUNNER_ARCH": "X64",
            "RUNNER_TEMP": str(self.temp), "GITHUB_WORKSPACE": str(self.workspace), "GITHUB_ACTION_PATH": str(self.service.action),
            "PATH": ":".join([*self.path, self.machine.env["PATH"]]),
            **{name: str(file) for name, file in files.items()},
            **{name: filled(value, contexts) for name, value in step.get("env", {}).items()},
        }
        code, said = self.machine.run(["bash", "--noprofile", "--norc", "-eo", "pipefail", script], self.workspace, env)
        self.job.log += said
        self.job.summary += files["GITHUB_STEP_SUMMARY"].read_text()
        self.path = files["GITHUB_PATH"].read_text().splitlines() + self.path
        outputs.update(line.split("=", 1) for line in files["GITHUB_OUTPUT"].read_text().splitlines())
        if files["GITHUB_ENV"].read_text():
            raise Failure(f"{step.get('name')}: writes to GITHUB_ENV")
        return code == 0, f"failure, exit code {code}" if code else "success"

    def checkout(self, _inputs, _outputs):
        clone(self.machine, self.service.repository, self.workspace)
        return True, "success"

    def cache_restore(self, inputs, outputs):
        path = inputs["path"]
        for key in [inputs["key"], *inputs.get("restore-keys", "").split()]:
            found = [cache for cache in self.service.caches if cache[1] == path and cache[0].startswith(key)]
            exact = [cache for cache in found if cache[0] == key]
            if found:
                key, _, folder = (exact or found)[-1]
                copy(folder, self.workspace / path)
                outputs["cache-hit"] = "true" if exact else "false"
                return True, "restored" if exact else "restored by prefix"
        return True, "nothing to restore"

    def cache_save(self, inputs, _outputs):
        key, path = inputs["key"], inputs["path"]
        if not key or len(key) > 512 or "," in key:
            raise Failure(f"{key}: is no key of a cache")
        if any(cache[:2] == (key, path) for cache in self.service.caches):
            return True, "exists already"
        if not (self.workspace / path).exists():
            return True, "nothing to save"
        folder = self.machine.root / "github/caches" / str(len(self.service.caches))
        copy(self.workspace / path, folder)
        self.service.caches.append((key, path, folder))
        return True, "saved"

    def upload_artifact(self, inputs, _outputs):
        name, source = inputs["name"], self.workspace / inputs["path"]
        if not name or set(name) & set('"/\\:<>|*?\r\n') or name in self.run.artifacts:
            return False, f"failure: {name!r} is no name of a new artifact"
        files = [file for file in source.rglob("*") if file.is_file()] if inputs["path"] else []
        files = [file for file in files if not any(part.startswith(".") for part in file.relative_to(source).parts)]
        if not files:
            return inputs["if-no-files-found"] != "error", "nothing to upload"
        target = self.machine.root / f"github/artifacts/{self.run.number}" / name
        for file in files:
            copied = target / file.relative_to(source)
            copied.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, copied)
        self.run.artifacts[name] = target
        return True, f"{name}: {len(files)} files"

    def download_artifact(self, inputs, _outputs):
        names = fnmatch.filter(sorted(self.run.artifacts), inputs["pattern"])
        for name in names:
            copy(self.run.artifacts[name], self.workspace / inputs["path"] / name)
        return True, f"{len(names)} artifacts"
