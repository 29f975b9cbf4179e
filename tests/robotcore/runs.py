"""Apps with an end that the test chooses, and observers of runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.session import Run, RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.safety import STOPPED
from tests.robotcore.fakes import Deed

Runner = Callable[..., RunResult]
"""The type of the fixture `perform`, which runs an app."""


class Watcher:
    """An observer that collects its calls: the method and the argument."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, Any]] = []

    def begin(self, run: Run) -> None:
        self.heard.append(("begin", run))

    def tick(self, record: TickRecord) -> None:
        self.heard.append(("tick", record))

    def end(self, result: RunResult) -> None:
        self.heard.append(("end", result))


class Once(Watcher):
    """An observer that calls a function in one tick of a run."""

    def __init__(self, deed: Callable[[], object], tick: int = 5) -> None:
        super().__init__()
        self._deed, self._left = deed, tick

    def tick(self, record: TickRecord) -> None:
        self._left -= 1
        if self._left == 0:
            self._deed()


def ended_by(watcher: Watcher) -> str:
    """Return the cause of the last intervention in the last record."""
    records: list[TickRecord] = [found for what, found in watcher.heard if what == "tick"]
    last = records[-1].interventions[-1]
    assert last.sent == STOPPED
    return last.cause


def driving(robot: Robot, left: float = 2.0) -> None:
    robot.drive.set_wheels(left, 2.0)


def then(end: Callable[[Robot], object]) -> Deed:
    """Return an app that drives for two ticks and then calls ``end``."""
    ticks: list[int] = []

    def deed(robot: Robot) -> Status:
        ticks.append(1)
        driving(robot)
        if len(ticks) < 3:
            return Status.RUNNING
        said = end(robot)
        return said if isinstance(said, Status) else Status.RUNNING

    return Deed(deed)


def raising(error: BaseException) -> Deed:
    def deed(robot: Robot) -> None:
        raise error

    return then(deed)
