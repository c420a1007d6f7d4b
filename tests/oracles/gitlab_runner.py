"""A runner of GitLab pipelines without GitLab: checkout, caches and artifacts are copies of folders, and scripts run in a shell.

It knows what ci/gitlab.yml and the pipeline of docs/suites.md use. Other keys and variables are errors.
"""

import pathlib
import re
import shutil
from dataclasses import dataclass, field

import yaml

from ci_machine import Failure, clone, copy

JOB_KEYS = {"extends", "image", "cache", "before_script", "script", "artifacts", "when", "needs", "parallel"}
SHELLS = {"bash": ["bash", "-eo", "pipefail"], "sh": ["sh", "-e"]}


@dataclass
class Job:
    """A job that ran: its outcome and output, the folder of its artifact, and its reports by kind."""

    name: str
    passes: bool
    log: str
    artifact: pathlib.Path
    reports: dict = field(default_factory=dict)


def merged(base, changes):
    """Dictionaries are merged by key; everything else is replaced."""
    both = dict(base)
    for key, value in changes.items():
        both[key] = merged(base[key], value) if isinstance(value, dict) and isinstance(base.get(key), dict) else value
    return both


class GitLab:
    """The service: pipelines, caches of a project, and one runner."""

    def __init__(self, machine, template, repository, table):
        self.machine, self.repository, self.table = machine, repository, table
        self.template = yaml.safe_load(pathlib.Path(template).read_text())
        self.workspace = machine.root / "gitlab/work/renders"
        self.count, self.caches = 0, set()

    def run(self, scenario, pipeline, shell="bash"):
        """Runs all jobs of a pipeline, one after the other; returns those that ran."""
        self.count += 1
        pipeline = merged(self.template, {key: value for key, value in pipeline.items() if key != "include"})
        jobs = []
        for name in (name for name in pipeline if name != "variables" and not name.startswith(".")):
            job = self.extended(pipeline, name)
            unknown = set(job) - JOB_KEYS
            if unknown:
                raise Failure(f"job {name}: unknown {', '.join(sorted(unknown))}")
            needs = [done for done in jobs if done.name.split(" ")[0] in job.get("needs", [])]
            if not all(done.passes for done in needs) and job.get("when") != "always":
                self.table.add(scenario, name, "", "job skipped")
                continue
            total = job.get("parallel", 1)
            for index in range(1, total + 1):
                # A job without parallel has the total, and no index.
                own = {"CI_NODE_INDEX": str(index)} if "parallel" in job else {}
                title = f"{name} {index}/{total}" if "parallel" in job else name
                variables = {**pipeline["variables"], **own, "CI_NODE_TOTAL": str(total), "CI": "true", "GITLAB_CI": "true",
                             "CI_JOB_NAME": title, "CI_JOB_NAME_SLUG": re.sub(r"[^a-z0-9]+", "-", title), "CI_PROJECT_DIR": str(self.workspace)}
                jobs.append(self.job(scenario, title, job, variables, needs, shell))
        return jobs

    def extended(self, pipeline, name):
        job = pipeline[name]
        return merged(self.extended(pipeline, job["extends"]), job) if "extends" in job else job

    def job(self, scenario, title, job, variables, needs, shell):
        def add(step, outcome):
            self.table.add(scenario, title, step, outcome)

        def expanded(text):
            return re.sub(r"\$\{?(\w+)\}?", lambda match: str(variables[match[1]]), text)

        clone(self.machine, self.repository, self.workspace)
        expanded(job["image"])
        for cache in job["cache"]:
            add(f"restore {cache['paths'][0]}", self.restore(expanded(cache["key"]), expanded(cache["paths"][0])))
        for done in needs:
            copy(done.artifact, self.workspace)

        # The lines of both scripts run in one shell.
        script = "\n".join([*job["before_script"], *job["script"]])
        code, said = self.machine.run([*SHELLS[shell], "-c", script], self.workspace,
                                      {name: str(value) for name, value in variables.items()})
        add(f"scripts in {shell}", f"failure, exit code {code}" if code else "success")

        for cache in job["cache"]:
            if cache["when"] == "always" or not code:
                add(f"save {cache['paths'][0]}", self.save(expanded(cache["key"]), expanded(cache["paths"][0])))
        done = Job(title, not code, said, self.machine.root / f"gitlab/artifacts/{self.count}" / title.replace("/", "-"))
        self.keep(done, job["artifacts"], code, add)
        return done

    def cache_folder(self, key):
        if "/" in key or not key.strip("."):
            raise Failure(f"{key}: is no key of a cache")
        return self.machine.root / "gitlab/caches" / key

    def restore(self, key, path):
        folder = self.cache_folder(key) / path
        if not folder.exists():
            return "nothing to restore"
        copy(folder, self.workspace / path)
        return "restored"

    def save(self, key, path):
        if not (self.workspace / path).exists():
            return "nothing to save"
        shutil.rmtree(self.cache_folder(key), ignore_errors=True)
        copy(self.workspace / path, self.cache_folder(key) / path)
        return "saved"

    def keep(self, done, artifacts, code, add):
        """Stores the artifacts of a job. Paths that do not exist are left out."""
        done.artifact.mkdir(parents=True)
        count = 0
        for path in artifacts["paths"] if artifacts["when"] == "always" or not code else []:
            if (self.workspace / path).exists():
                copy(self.workspace / path, done.artifact / path)
                count += sum(file.is_file() for file in (done.artifact / path).rglob("*"))
        add("upload artifacts", f"{count} files")
        for kind, path in artifacts.get("reports", {}).items():
            if (self.workspace / path).exists():
                done.reports[kind] = (self.workspace / path).read_text()
