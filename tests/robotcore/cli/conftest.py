from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from robotcore import RunRequest
from robotcore.cli.main import execute
from robotcore.sweep import Sweep
from robotcore.sweep.single_run import RunOutput, perform


class Answer(NamedTuple):
    """The exit status and the output of a command."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        lines = self.out.splitlines()
        assert len(lines) == 1
        return json.loads(lines[0])

    @property
    def plain_err(self) -> str:
        """The output on stderr without the lines of markers that Python 3.11 and newer add to tracebacks."""
        return "".join(line for line in self.err.splitlines(keepends=True) if line.strip(" \n~^") or line == "\n")


Cli = Callable[..., Answer]
AppFile = Callable[[str], str]


@pytest.fixture
def cli(capfd: pytest.CaptureFixture[str]) -> Cli:
    """Return a function that runs a command in this process, and returns its answer."""

    def run(*arguments: str) -> Answer:
        status = execute(arguments)
        return Answer(status, *capfd.readouterr())

    return run


@pytest.fixture
def app_file(tmp_path: Path) -> AppFile:
    """Return a function that writes an app whose third tick executes lines of Python, and returns the app's file."""

    def write(lines: str) -> str:
        file = tmp_path / "odd.py"
        file.write_text(
            f"""
import os, signal
from robotcore import Behaviour, Role, Status

class Odd(Behaviour):
    needs = frozenset({{Role.DRIVE}})
    ticks = 0

    def step(self, robot):
        self.ticks += 1
        robot.drive.set_velocity(0.1, 0.0)
        if self.ticks == 3:
            {lines}
        return Status.RUNNING
"""
        )
        return str(file)

    return write


@pytest.fixture
def requests(monkeypatch: pytest.MonkeyPatch) -> list[RunRequest]:
    """Execute the runs of a sweep in this process. Return the list of their requests."""
    requests: list[RunRequest] = []

    def perform_here(_: object, sweep: Sweep, missing: Iterable[RunRequest]) -> Iterator[RunOutput]:
        for request in missing:
            requests.append(request)
            yield perform(request)

    monkeypatch.setattr("robotcore.sweep.engine.LocalEngine.perform", perform_here)
    return requests


class RecordedRun(NamedTuple):
    file: Path
    ticks: int
    time: str


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> RecordedRun:
    """Record a complete run of green-search."""
    file = tmp_path_factory.mktemp("recorded") / "search.mcap"
    with redirect_stdout(StringIO()) as out:
        assert execute(["run", "green-search", "--seed", "7", "--record", str(file), "--json"]) == 0
    answer = json.loads(out.getvalue())
    return RecordedRun(file, answer["ticks"], f"{answer['sim_time_s']:.2f} s")


@pytest.fixture(scope="session")
def search_recording(recorded: RecordedRun) -> Path:
    """Return the file of `recorded`."""
    return recorded.file


@pytest.fixture(scope="session")
def brief_recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record one second of mark-green, and return the small file. Tests damage copies of it."""
    file = tmp_path_factory.mktemp("recorded") / "brief.mcap"
    arguments = ["run", "mark-green", "--robot", "lookout", "--world", "open", "--timeout", "1", "--json"]
    assert execute([*arguments, "--record", str(file)]) == 1
    return file
