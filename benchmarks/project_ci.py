"""Measure how long the CI of a new project takes, and run each step of its workflow files.

`robotcore new` makes a project from a wheel that is built here. The project is committed and cloned. Then each `run:`
of the workflow for GitHub, or each line of `script:` of the one for GitLab, runs in the clone, in a fresh virtual
environment with an empty cache of pip. pip finds robotcore in the folder of the wheel. The servers'
own steps are replaced: a clone, an environment, and a check that the files of the results exist.

The bound: each workflow passes, and takes at most 180 s. --here uses this environment, and installs nothing.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET
from zipfile import ZipFile

import yaml

from benchmarks.report import parse_options, print_table

BOUND_S = 180.0
ROOT = Path(__file__).parents[1]
KINDS = {"project": (), "driver": ("--driver",), "kind": ("--kind",)}
"""The options of ``robotcore new`` for each template."""

NAME = "scout-9"
BUILTIN = {"default", "include", "stages", "variables", "workflow"}
"""The keys of GitLab's file that are no jobs."""


class Workflow(NamedTuple):
    """The commands of a workflow file, and the files that it uploads."""

    commands: list[str]
    results: list[str]


class Step(NamedTuple):
    """A command of a workflow that has ended, and its durations in real time and on the processors."""

    command: str
    time_s: float
    cpu_s: float

    @classmethod
    def measure(cls, command: str, began: tuple[float, float]) -> Step:
        """Return a step that ends now, and whose `read_clocks` was ``began``."""
        return cls(command, *(end - begin for begin, end in zip(began, read_clocks(), strict=True)))


def read_clocks() -> tuple[float, float]:
    """Return the real time, and the time of the processors for all ended programs, in seconds."""
    used = getrusage(RUSAGE_CHILDREN)
    return perf_counter(), used.ru_utime + used.ru_stime


def read_github(project: Path) -> Workflow:
    """Return the workflow in the only file below ``.github/workflows``."""
    (file,) = (project / ".github" / "workflows").iterdir()
    steps = [step for job in yaml.safe_load(file.read_text())["jobs"].values() for step in job["steps"]]
    uploads = [step["with"]["path"] for step in steps if "upload-artifact" in step.get("uses", "")]
    results = [line for each in uploads for line in each.split()]
    return Workflow([step["run"] for step in steps if "run" in step], results)


def read_gitlab(project: Path) -> Workflow:
    """Return the workflow in ``.gitlab-ci.yml``."""
    content: dict[str, Any] = yaml.safe_load((project / ".gitlab-ci.yml").read_text())
    jobs = [job for name, job in content.items() if name not in BUILTIN]
    results = [path for job in jobs for path in job["artifacts"].get("paths", [])]
    results += [job["artifacts"]["reports"]["junit"] for job in jobs]
    return Workflow([line for job in jobs for line in job["script"]], results)


WORKFLOWS = {"github": read_github, "gitlab": read_gitlab}


def main() -> None:
    options = parse_options(__doc__, kinds="project,driver,kind", workflows="github,gitlab", here=False)
    rows, problems = [], []
    with TemporaryDirectory() as scratch:
        wheel = None if options.here else build_wheel(Path(scratch))
        for kind, server in product(options.kinds.split(","), options.workflows.split(",")):
            folder = Path(scratch, f"{kind}-{server}")
            folder.mkdir()
            steps, problem = run_workflow(kind, server, folder, wheel)
            total_s, total_cpu_s = (sum(times) for times in list(zip(*steps, strict=True))[1:])
            steps.append(Step("all", total_s, total_cpu_s))
            rows += [(kind, server, step.command, f"{step.time_s:.1f}", f"{step.cpu_s:.1f}") for step in steps]
            if problem or total_s > BOUND_S:
                problems.append(f"{kind}, {server}: {problem or f'{total_s:.0f} s, more than {BOUND_S:.0f} s'}")
    print_table(["template", "workflow", "step", "seconds", "CPU seconds"], rows)
    print("\n".join(problems) or f"Each workflow passes in at most {BOUND_S:.0f} s.")
    sys.exit(bool(problems))


def build_wheel(folder: Path) -> Path:
    """Build the wheel of this repository."""
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(ROOT)]
    call(command, ROOT)
    (wheel,) = folder.glob("*.whl")
    ZipFile(wheel).extractall(folder / "content")
    return wheel


def run_workflow(kind: str, server: str, folder: Path, wheel: Path | None) -> tuple[list[Step], str]:
    """Make a project, clone it, and run its workflow. Return the steps, and a problem or an empty text."""
    clone = make_clone(kind, folder, wheel)
    began = read_clocks()
    environment = make_environment(folder, wheel)
    steps = [Step.measure("a fresh environment", began)]
    workflow = WORKFLOWS[server](clone)
    for command in workflow.commands:
        if wheel is None and "install" in command:
            continue
        began = read_clocks()
        ran = call(["bash", "-e", "-o", "pipefail", "-c", command], clone, environment, check=False)
        steps.append(Step.measure(command, began))
        if ran.returncode:
            return steps, f"{command!r} ends with {ran.returncode}:\n{ran.stdout}"
    return steps, "; ".join(find_result_problems(clone, workflow))


def make_clone(kind: str, folder: Path, wheel: Path | None) -> Path:
    """Make a project from the wheel, commit it, and clone it. So only files that git keeps are in the clone."""
    path = {} if wheel is None else {"PYTHONPATH": str(wheel.parent / "content")}
    new = [sys.executable, "-m", "robotcore", "new", *KINDS[kind], NAME]
    call(new, folder, os.environ | path)
    author = ("-c", "user.name=a", "-c", "user.email=a@b.c")
    for arguments in (("init", "-q"), ("add", "."), (*author, "commit", "-q", "-m", "Begin")):
        call(["git", *arguments], folder / NAME)
    call(["git", "clone", "-q", NAME, "clone"], folder)
    return folder / "clone"


def make_environment(folder: Path, wheel: Path | None) -> Mapping[str, str]:
    """Return the environment variables of a job, whose ``python`` is that of a fresh virtual environment."""
    if wheel is None:
        return os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "CI": "true"}
    call([sys.executable, "-m", "venv", str(folder / "venv")], folder)
    variables = {
        "PATH": f"{folder / 'venv' / 'bin'}:{os.environ['PATH']}",
        "VIRTUAL_ENV": str(folder / "venv"),
        "PIP_CACHE_DIR": str(folder / "cache"),
        "PIP_FIND_LINKS": str(wheel.parent),
        "CI": "true",
    }
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | variables


def call(
    command: Sequence[str], folder: Path, environment: Mapping[str, str] | None = None, *, check: bool = True
) -> subprocess.CompletedProcess[str]:
    """Run a command in a folder, and return its status and its output."""
    return subprocess.run(  # noqa: S603  our own
        command,
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=check,
    )


def find_result_problems(clone: Path, workflow: Workflow) -> Iterator[str]:
    """Yield the problems of the files that a workflow uploads."""
    for pattern in workflow.results:
        if not any(clone.glob(pattern.rstrip("/"))):
            yield f"there is no {pattern}"
    reports = [file for file in clone.rglob("*.xml") if ET.parse(file).getroot().tag.startswith("testsuite")]  # noqa: S314  written here
    for file in reports:
        suites = list(ET.parse(file).getroot().iter("testsuite"))  # noqa: S314  the same
        if not any(int(suite.attrib["tests"]) for suite in suites):
            yield f"{file.name} has no test"
        if any(int(suite.attrib[key]) for suite in suites for key in ("failures", "errors")):
            yield f"{file.name} has a failure"
    if not reports:
        yield "there is no JUnit file"


if __name__ == "__main__":
    main()
