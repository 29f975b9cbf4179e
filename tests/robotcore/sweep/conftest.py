from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from robotcore import Outcome, RunRequest, RunResult
from robotcore.sweep import Record, Sweep

AppFile = Callable[..., str]

SWEEP_ID = "int(open(f'/proc/{os.getppid()}/stat').read().rpartition(')')[2].split()[1])"
"""The expression in an app for the process id of the sweep, which is the parent of the supervisor."""

APP = """
import os, signal
from threading import Event
from robotcore import Behaviour, Role, Status
{head}

class Odd(Behaviour):
    needs = frozenset({{Role.DRIVE, Role.CAMERA}})
    ticks = 0

    def step(self, robot):
        self.ticks += 1
        robot.drive.set_velocity(0.1, 0.0)
        x = robot.camera.read().image.mean()
        if self.ticks == 3:
            {code}
        return Status.SUCCESS if self.ticks == 15 else Status.RUNNING
"""


@pytest.fixture
def app_file(tmp_path: Path) -> AppFile:
    """Return a function that writes an app into a file, and returns the file's name.

    The app executes ``code`` in its third tick, and ends after 0.7 s. ``head`` is code at the top of the file.
    """

    def write(code: str = "pass", head: str = "") -> str:
        file = tmp_path / "app" / "odd.py"
        file.parent.mkdir(exist_ok=True)
        file.write_text(APP.format(code=code, head=head))
        return str(file)

    return write


def make_sweep(app: str, seeds: int = 2, worlds: tuple[str, ...] = ("open",)) -> Sweep:
    return Sweep(RunRequest(app, timeout_s=5.0), ("kinematic",), worlds, tuple(range(1, seeds + 1)))


def make_record(
    outcome: Outcome = Outcome.SUCCESS,
    *,
    verified: bool | None = True,
    contacts: int | None = 0,
    world: str = "open",
    seed: int = 1,
    time: float = 10.0,
    reason: str = "",
    judge: str | None = None,
) -> Record:
    result = RunResult(
        *("green-search", "kinematic", "rover", world, seed, outcome, 0, reason),
        verified=verified,
        judge=judge,
        sim_time_s=time,
        contacts=contacts,
    )
    return Record(
        result, ((0.0, 1.0, 2.0), (0.5, 1.1, 2.0)), f"robotcore run green-search --world {world} --seed {seed}"
    )
