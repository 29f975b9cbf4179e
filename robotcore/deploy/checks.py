"""Checks of a project before a push: its tests, and the check of its description files."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from subprocess import CompletedProcess
from typing import TypeVar

from robotcore.deploy.progress import OnStep, OnText, Step
from robotcore.deploy.project import Project
from robotcore.deploy.staging import list_files
from robotcore.description import RobotDescription, load_world
from robotcore.description.doubtful_values import find_bodies_outside, find_doubtful_values
from robotcore.errors import BackendMissingError, DescriptionError, ReleaseCheckError
from robotcore.hal.backend import load_backend
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.text import escape

POLL_S = 0.5
"""The time between two calls of ``on_poll`` in `run_python`, in s."""


@dataclass(frozen=True)
class CheckResult:
    """The result of a check that the project passed."""

    summary: str
    """The result in one line."""
    warnings: tuple[str, ...] = ()
    """Warnings, a line each."""


def run_python(
    folder: Path | None,
    arguments: Sequence[str],
    environment: Mapping[str, str] | None = None,
    *,
    limit_s: float,
    on_poll: Callable[[], object] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run this Python in a process with an empty stdin, and return its exit status and output.

    folder: the working folder; None for the current folder.
    arguments: the command-line arguments of Python.
    environment: environment variables that override those of this process.
    limit_s: the time limit in s. After it, the process is killed, and TimeoutError is raised.
    on_poll: this function is called every `POLL_S` while the process runs.
    """
    clock = MonotonicClock()
    with subprocess.Popen(  # noqa: S603  no shell
        [sys.executable, *arguments],
        cwd=folder,
        env={**os.environ, **(environment or {})},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="backslashreplace",
    ) as process:
        try:
            while clock.now() < limit_s:
                with suppress(subprocess.TimeoutExpired):
                    out, err = process.communicate(timeout=min(POLL_S, limit_s))
                    return subprocess.CompletedProcess(process.args, process.returncode, out, err)
                if on_poll:
                    on_poll()
        finally:
            process.kill()
    raise TimeoutError(f"did not end within {limit_s:g} s")


def format_command(project: Project, line: str) -> str:
    """Return a shell command that runs a command line in the project's folder."""
    is_here = project.folder is None or project.folder == Path.cwd().resolve()
    return line if is_here else f"cd {shlex.quote(str(project.folder))} && {line}"


def read_process_error(process: subprocess.CompletedProcess[str]) -> str:
    """Return the error message that a process printed, without the prefix ``error:``, or else its exit status."""
    return (process.stderr.strip() or process.stdout.strip() or f"exit status {process.returncode}").removeprefix(
        "error: "
    )


NO_TESTS = 5
"""The exit status of pytest if it finds no test."""

LIMIT_S = 600.0
"""The time limit of the tests, in s."""

MAX_FAILURES = 5
"""The greatest number of failing tests that an error message names."""

_TEST_FILE = re.compile(r"(?:.*/)?(?:test_[^/]*|[^/]*_test)\.py", re.DOTALL)
_COUNTS = re.compile(r"^=* ?(\d+ [a-z]+(?:, \d+ [a-z]+)*) in [\d.]+s", re.MULTILINE)
_FAILURES = re.compile(r"^(?:FAILED|ERROR) .*", re.MULTILINE)


def run_tests(project: Project, report: OnText) -> CheckResult:
    """Run the project's tests in the user's folder, because they may need files that are not sent.

    Raises ReleaseCheckError if a test fails or pytest is missing.
    """
    if project.folder is None:
        return CheckResult("none: the app is installed, and no files of yours are sent")
    if not any(map(_TEST_FILE.fullmatch, list_files(project.folder).names)):
        return CheckResult(
            "none", ("the project has no tests. robotcore new writes a test that runs the app in simulation",)
        )
    if find_spec("pytest") is None:
        raise ReleaseCheckError(
            "tests: pytest is not installed. Run pip install pytest, or skip all checks: --skip-checks",
            kind="no-pytest",
        )
    report("pytest")
    try:
        process = run_python(project.folder, ["-m", "pytest", "-q", "--color=no"], limit_s=LIMIT_S)
    except TimeoutError as error:
        again = format_command(project, "python -m pytest -v")
        raise ReleaseCheckError(
            f"tests: pytest {error}. A test may hang. Repair it, or skip all checks: --skip-checks\n"
            f"To find the test: {again}",
            kind="tests-hang",
            limit_s=LIMIT_S,
        ) from error
    if process.returncode == NO_TESTS:
        return CheckResult("none")
    if process.returncode:
        raise ReleaseCheckError(
            f"tests: {_format_failures(process)}\nTo repeat it: {format_command(project, 'python -m pytest')}",
            kind="tests-failed",
        )
    return CheckResult(_find_counts(process) or "passed")


def _find_counts(process: CompletedProcess[str]) -> str:
    found = _COUNTS.findall(process.stdout)
    return str(found[-1]) if found else ""


def _format_failures(process: CompletedProcess[str]) -> str:
    lines = _FAILURES.findall(process.stdout)[:MAX_FAILURES]
    last = (process.stderr.strip() or process.stdout.strip() or "no answer").splitlines()[-1]
    counts = _find_counts(process) or f"pytest ended with exit status {process.returncode}: {last}"
    return "\n  ".join((counts, *lines))


def check_descriptions(project: Project, report: OnText) -> CheckResult:
    """Check the description files of the robot and the world, and return their warnings.

    Raises ReleaseCheckError, whose message lists every mistake.
    """
    warnings: list[str] = []
    for name in filter(None, (project.robot, project.world)):
        report(escape(name))
        try:
            warnings += _check_description(project, name)
        except DescriptionError as error:
            again = format_command(project, shlex.join(["robotcore", "check", name]))
            # `robotcore check` does not miss a section, because it checks only those in the file
            repeat = "" if error.kind == "no-section" else f"\nTo repeat it: {again}"
            raise ReleaseCheckError(f"check: {error}{repeat}", kind="description-check-failed") from error
    return CheckResult(
        "; ".join(f"{escape(name)}: OK" for name in filter(None, (project.robot, project.world))), tuple(warnings)
    )


def _check_description(project: Project, name: str) -> list[str]:
    if name == project.world:
        return [f"warning: {each}" for each in find_bodies_outside(load_world(project.resolve(name)))]
    robot = project.load_description()
    doubts = [f"warning: {each}" for each in find_doubtful_values(robot)]
    backends = sorted({*robot.backends, project.deploy.backend})
    return doubts + [warning for backend in backends for warning in _list_warnings(robot, backend)]


def _list_warnings(robot: RobotDescription, backend: str) -> Iterator[str]:
    try:
        loaded = load_backend(backend)
        loaded.check(robot)
        yield from (f"[{backend}] warning: {each}" for each in loaded.warnings(robot))
    except BackendMissingError as error:
        yield f"[{backend}] was not checked: {error}"


NAMES = ("tests", "check", "simulation")
"""The names of all checks, in the order in which they run."""

SubjectT = TypeVar("SubjectT")


def run_check(name: str, check: Callable[[SubjectT, OnText], CheckResult], subject: SubjectT, on_step: OnStep) -> str:
    """Run a check, and report its progress. Return a line for the manifest, such as ``tests: 12 passed``."""
    step = Step(name, on_step)
    result = check(subject, step.update)
    step.finish(result.summary, *result.warnings)
    return f"{name}: {result.summary}"
