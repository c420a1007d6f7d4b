"""What the emulated runners of GitHub and GitLab share: a machine with folders, the program behind a substitute of cargo, and a table."""

import os
import pathlib
import re
import shutil
import subprocess

CARGO = """#!/usr/bin/env bash
# Stands in for cargo: logs its arguments, and "installs" the program at --root.
set -euo pipefail
printf '%s\\n' "$*" >> '{log}'
[[ $1 == install && $2 == --locked ]]
while [[ $# -gt 0 && $1 != --root ]]; do shift; done
mkdir -p "$2/bin"
cp '{program}' "$2/bin/rayframe"
"""


class Failure(Exception):
    """A file of the repository is not as the emulated runner needs it, or an expectation does not hold."""


class Table:
    """The steps of all runs with their outcomes, and the expectations of all scenarios. Skipped steps are left out."""

    def __init__(self):
        self.rows, self.failures = [], 0

    def add(self, scenario, job, step, outcome):
        if outcome != "skipped":
            self.rows.append((scenario, job, step, outcome))

    def expect(self, scenario, what, holds):
        self.failures += not holds
        self.add(scenario, "", what, "as expected" if holds else "NOT AS EXPECTED")

    def of_service(self, service):
        """The table as one service writes to it, whose name precedes those of scenarios."""
        return ServiceTable(self, service)

    def text(self):
        rows = [("scenario", "job", "step or expectation", "outcome"), *self.rows]
        widths = [max(len(row[column]) for row in rows) for column in range(3)]
        return "\n".join("  ".join([*(cell.ljust(width) for cell, width in zip(row, widths)), row[3]]) for row in rows)


class ServiceTable:
    """The table as one service writes to it."""

    def __init__(self, table, service):
        self.table, self.service = table, service

    def add(self, scenario, *row):
        self.table.add(f"{self.service} {scenario}", *row)

    def expect(self, scenario, what, holds):
        self.table.expect(f"{self.service} {scenario}", what, holds)


class Machine:
    """A build machine: its folders lie under `root`, and its environment has nothing of this one but the PATH."""

    def __init__(self, root, program):
        self.root = pathlib.Path(root)
        self.cargo_log = self.root / "cargo.log"
        tools = self.root / "tools"
        home = self.root / "home"
        for folder in (tools, home):
            folder.mkdir(parents=True)
        cargo = tools / "cargo"
        cargo.write_text(CARGO.format(log=self.cargo_log, program=pathlib.Path(program).resolve()))
        cargo.chmod(0o755)
        self.env = {"PATH": f"{tools}:{os.environ['PATH']}", "HOME": str(home), "LANG": "C.UTF-8"}

    def installs(self):
        """The arguments of all calls of cargo."""
        return self.cargo_log.read_text().splitlines() if self.cargo_log.exists() else []

    def run(self, words, folder, env, script=None):
        """Exit code and output of a command; the output has the lines of both streams."""
        done = subprocess.run([str(word) for word in words], cwd=folder, env={**self.env, **env}, input=script, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300)
        return done.returncode, done.stdout


def fresh(folder):
    """The folder, empty."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def clone(machine, repository, workspace):
    """A checkout of the repository's newest commit."""
    shutil.rmtree(workspace, ignore_errors=True)
    code, said = machine.run(["git", "clone", "-q", repository, workspace], machine.root, {})
    if code:
        raise Failure(said)


def copy(source, target):
    """Copies a folder into another."""
    shutil.copytree(source, target, dirs_exist_ok=True)


def yaml_blocks(markdown, heading):
    """The texts of the YAML blocks below a heading of a document."""
    parts = re.split(r"^## ", markdown, flags=re.MULTILINE)
    section = next((part for part in parts if part.startswith(heading + "\n")), None)
    if section is None:
        raise Failure(f"there is no section {heading}")
    return re.findall(r"^```yaml\n(.*?)^```", section, flags=re.MULTILINE | re.DOTALL)
