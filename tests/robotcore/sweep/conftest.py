from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from robotcore import Outcome, RunRequest, RunResult
from robotcore.sweep import Record, Sweep

AppFile = Callable[..., str]

SWEEP = "int(open(f'/proc/{os.getppid()}/stat').read().rpartition(')')[2].split()[1])"
"""Code in an app for the id of the sweep's process, which is the parent of the supervisor."""

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
            {deed}
        return Status.SUCCESS if self.ticks == 15 else Status.RUNNING
"""


@pytest.fixture
def app_file(tmp_path: Path) -> AppFile:
    """Writes a file with an app that runs ``deed`` in its third tick, and ends after 0.7 s."""

    def write(deed: str = "pass", head: str = "") -> str:
        file = tmp_path / "app" / "odd.py"
        file.parent.mkdir(exist_ok=True)
        file.write_text(APP.format(deed=deed, head=head))
        return str(file)

    return write


def sweep_of(app: str, seeds: int = 2, worlds: tuple[str, ...] = ("open",)) -> Sweep:
    return Sweep(RunRequest(app, timeout_s=5.0), ("kinematic",), worlds, tuple(range(1, seeds + 1)))


def record_of(
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
