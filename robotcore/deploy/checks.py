"""The checks that a project must pass before it is sent: its tests and its descriptions, in separate processes."""

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
from typing import Generic, TypeVar

from robotcore.deploy.progress import OnStep, Say, begin_step
from robotcore.deploy.project import Project
from robotcore.deploy.staging import list_files
from robotcore.description import RobotDescription, load_world
from robotcore.errors import BackendMissingError, DescriptionError, UnprovenError
from robotcore.hal.backend import load_backend
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.text import escape

POLL_S = 0.5
"""Seconds between two calls of ``look`` while a process runs."""


@dataclass(frozen=True)
class CheckResult:
    """The result of a check in a line, with notes."""

    summary: str
    notes: tuple[str, ...] = ()


def run_python(
    folder: Path | None,
    words: Sequence[str],
    environment: Mapping[str, str] | None = None,
    *,
    limit_s: float,
    look: Callable[[], object] = lambda: None,
) -> subprocess.CompletedProcess[str]:
    """Run this Python with these arguments in a folder, with an empty stdin, and return its output.

    ``environment`` overrides that of this process. ``look`` is called every `POLL_S`. Raises TimeoutError after
    ``limit_s`` seconds. On every exception the process is killed.
    """
    clock = MonotonicClock()
    with subprocess.Popen(  # noqa: S603  words, and no shell to take them for anything else
        [sys.executable, *words],
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
                look()
        except BaseException:
            process.kill()
            raise
        process.kill()
    raise TimeoutError(f"no end within {limit_s:g} s")


def command_line(project: Project, line: str) -> str:
    """Return a shell line that repeats a command in the project's folder."""
    is_here = project.folder is None or project.folder == Path.cwd().resolve()
    return line if is_here else f"cd {shlex.quote(str(project.folder))} && {line}"


def process_error(process: subprocess.CompletedProcess[str]) -> str:
    """Return the error output of a process, without the prefix ``error:``."""
    return (process.stderr.strip() or process.stdout.strip() or f"exit status {process.returncode}").removeprefix(
        "error: "
    )


NO_TESTS = 5
"""The exit status of pytest if it found no test."""

LIMIT_S = 600.0
"""The time limit of the tests."""

MAX_FAILURES = 5
"""The number of failing tests that are named."""

_TEST_FILE = re.compile(r"(?:.*/)?(?:test_[^/]*|[^/]*_test)\.py", re.DOTALL)
_COUNTS = re.compile(r"^=* ?(\d+ [a-z]+(?:, \d+ [a-z]+)*) in [\d.]+s", re.MULTILINE)
_FAILURES = re.compile(r"^(?:FAILED|ERROR) .*", re.MULTILINE)


def run_tests(project: Project, say: Say) -> CheckResult:
    """Run the project's tests; raises UnprovenError if one fails or pytest is missing.

    They run in the user's folder, because they may need files that are not sent.
    """
    if project.folder is None:
        return CheckResult("none: what is sent is installed, and nothing of yours")
    if not any(map(_TEST_FILE.fullmatch, list_files(project.folder).names)):
        return CheckResult(
            "none", ("the project has no tests; robotcore new makes one that runs the app in simulation",)
        )
    if find_spec("pytest") is None:
        raise UnprovenError(
            "tests: pytest is not installed. Run pip install pytest, or send them untried: --skip-checks",
            kind="no-pytest",
        )
    say("pytest")
    try:
        process = run_python(project.folder, ["-m", "pytest", "-q", "--color=no"], limit_s=LIMIT_S)
    except TimeoutError as error:
        again = command_line(project, "python -m pytest -v")
        raise UnprovenError(
            f"tests: {error}. Does one of them hang? Mend it, or send them untried: --skip-checks\n"
            f"Which one that is: {again}",
            kind="tests-hang",
            limit_s=LIMIT_S,
        ) from error
    if process.returncode == NO_TESTS:
        return CheckResult("none")
    if process.returncode:
        raise UnprovenError(
            f"tests: {_format_failures(process)}\nRepeat it: {command_line(project, 'python -m pytest')}",
            kind="tests-failed",
        )
    return CheckResult(_find_counts(process) or "passed")


def _find_counts(process: CompletedProcess[str]) -> str:
    found = _COUNTS.findall(process.stdout)
    return str(found[-1]) if found else ""


def _format_failures(process: CompletedProcess[str]) -> str:
    """Return the names of the first failing tests, or the last line of pytest."""
    lines = _FAILURES.findall(process.stdout)[:MAX_FAILURES]
    last = (process.stderr.strip() or process.stdout.strip() or "no answer").splitlines()[-1]
    counts = _find_counts(process) or f"pytest ended with exit status {process.returncode}: {last}"
    return "\n  ".join((counts, *lines))


def check_descriptions(project: Project, say: Say) -> CheckResult:
    """Check the descriptions, with their warnings as notes; raises UnprovenError with every fault."""
    notes: list[str] = []
    for name in filter(None, (project.robot, project.world)):
        say(escape(name))
        try:
            notes += _check_description(project, name)
        except DescriptionError as error:
            again = command_line(project, shlex.join(["robotcore", "check", name]))
            raise UnprovenError(f"check: {error}\nRepeat it: {again}", kind="description-check-failed") from error
    return CheckResult(
        "; ".join(f"{escape(name)}: OK" for name in filter(None, (project.robot, project.world))), tuple(notes)
    )


def _check_description(project: Project, name: str) -> list[str]:
    if name == project.world:
        load_world(project.resolve(name))
        return []
    robot = project.load_description()
    return [note for backend in {*robot.backends, project.backend} for note in _warnings(robot, backend)]


def _warnings(robot: RobotDescription, backend: str) -> Iterator[str]:
    """Yield a backend's warnings on its section; raises DescriptionError if the section is wrong or missing."""
    try:
        loaded = load_backend(backend)
        loaded.check(robot)
        yield from (f"[{backend}] warning: {each}" for each in loaded.warnings(robot))
    except BackendMissingError as error:
        yield f"[{backend}] was not checked: {error}"


SubjectT = TypeVar("SubjectT")


@dataclass(frozen=True)
class Check(Generic[SubjectT]):
    """One of the things to pass. ``run`` returns the result, or raises UnprovenError: why, and what repeats it.

    It also raises what is wrong with the project's files, or with this machine, as it is. ``say`` is told what goes on.
    """

    name: str
    run: Callable[[SubjectT, Say], CheckResult]


CHECKS_OF_PROJECT = (Check[Project]("tests", run_tests), Check[Project]("check", check_descriptions))
"""The checks that run in the user's folder."""

SIMULATION = "simulation"

NAMES = (*(check.name for check in CHECKS_OF_PROJECT), SIMULATION)


def run_checks(checks: Sequence[Check[SubjectT]], subject: SubjectT, on_step: OnStep) -> tuple[str, ...]:
    """Pass checks; return a line for each, as a release keeps them: ``tests: 12 passed``."""
    lines = []
    for check in checks:
        step = begin_step(check.name, on_step)
        result = check.run(subject, step.update)
        step.finish(result.summary, *result.notes)
        lines.append(f"{check.name}: {result.summary}")
    return tuple(lines)


def skip_checks(on_step: OnStep) -> tuple[str, ...]:
    """Say that none is passed; return a line for each, as a release keeps them."""
    begin_step("skipped", on_step).finish(", ".join(NAMES))
    return tuple(f"{name}: skipped" for name in NAMES)
