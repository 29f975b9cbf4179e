"""The project's own tests."""

from __future__ import annotations

import re
from importlib.util import find_spec
from subprocess import CompletedProcess

from robotcore.deploy.project import Project
from robotcore.deploy.proof.proof import Proof, Say, ask, command_line
from robotcore.deploy.staging.files import listed
from robotcore.errors import UnprovenError

NO_TESTS = 5
"""pytest's exit status where it found none."""

LIMIT_S = 600.0
"""Tests that take longer keep everybody from pushing; or one of them hangs."""

MAX_FAILURES = 5
"""So many failing tests are named; the command tells of all."""

_IS_TEST = re.compile(r"(?:.*/)?(?:test_[^/]*|[^/]*_test)\.py", re.DOTALL)
_COUNTS = re.compile(r"^=* ?(\d+ [a-z]+(?:, \d+ [a-z]+)*) in [\d.]+s", re.MULTILINE)
_FAILURES = re.compile(r"^(?:FAILED|ERROR) .*", re.MULTILINE)


def prove(project: Project, say: Say) -> Proof:
    """Return how many tests passed; raises UnprovenError where one does not, or none can be run.

    They run in the user's own folder, as he runs them: they may need what is not sent.
    """
    if project.folder is None:
        return Proof("none: what is sent is installed, and nothing of yours")
    if not any(map(_IS_TEST.fullmatch, listed(project.folder).names)):
        return Proof("none", ("the project has no tests; robotcore new makes one that runs the app in simulation",))
    if find_spec("pytest") is None:
        raise UnprovenError(
            "tests: pytest is not installed. Run pip install pytest, or send them untried: --skip-checks"
        )
    say("pytest")
    try:
        asked = ask(project.folder, ["-m", "pytest", "-q", "--color=no"], limit_s=LIMIT_S)
    except TimeoutError as error:
        again = command_line(project, "python -m pytest -v")
        raise UnprovenError(
            f"tests: {error}. Does one of them hang? Mend it, or send them untried: --skip-checks\n"
            f"Which one that is: {again}"
        ) from error
    if asked.returncode == NO_TESTS:
        return Proof("none")
    if asked.returncode:
        raise UnprovenError(f"tests: {_failed(asked)}\nRepeat it: {command_line(project, 'python -m pytest')}")
    return Proof(_counts(asked) or "passed")


def _counts(asked: CompletedProcess[str]) -> str:
    found = _COUNTS.findall(asked.stdout)
    return str(found[-1]) if found else ""


def _failed(asked: CompletedProcess[str]) -> str:
    """Return what failed: the first few tests by their names, or the last line of what pytest said."""
    lines = _FAILURES.findall(asked.stdout)[:MAX_FAILURES]
    last = (asked.stderr.strip() or asked.stdout.strip() or "no answer").splitlines()[-1]
    counts = _counts(asked) or f"pytest ended with exit status {asked.returncode}: {last}"
    return "\n  ".join((counts, *lines))
