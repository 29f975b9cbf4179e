"""Apps that end as a test chooses, and observers of runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.session import RunContext, RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.safety.velocity_limits import STOPPED
from tests.robotcore.fakes import FunctionApp

Runner = Callable[..., RunResult]
"""The type of the fixture `perform`, which runs an app."""


class Watcher:
    """An observer that collects its calls: the method and the argument."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, Any]] = []

    def begin(self, run: RunContext) -> None:
        self.calls.append(("begin", run))

    def tick(self, record: TickRecord) -> None:
        self.calls.append(("tick", record))

    def end(self, result: RunResult) -> None:
        self.calls.append(("end", result))


class CallOnce(Watcher):
    """An observer that calls a function in one tick of a run."""

    def __init__(self, function: Callable[[], object], tick: int = 5) -> None:
        super().__init__()
        self._function, self._left = function, tick

    def tick(self, record: TickRecord) -> None:
        self._left -= 1
        if self._left == 0:
            self._function()


def last_cause(watcher: Watcher) -> str:
    """Return the cause of the last intervention in the last record."""
    records: list[TickRecord] = [found for what, found in watcher.calls if what == "tick"]
    last = records[-1].interventions[-1]
    assert last.sent == STOPPED
    return last.cause


def drive_wheels(robot: Robot, left: float = 2.0) -> None:
    robot.drive.set_wheels(left, 2.0)


def drive_then(end: Callable[[Robot], object]) -> FunctionApp:
    """Return an app that drives for two ticks and then calls ``end``."""
    ticks: list[int] = []

    def step(robot: Robot) -> Status:
        ticks.append(1)
        drive_wheels(robot)
        if len(ticks) < 3:
            return Status.RUNNING
        status = end(robot)
        return status if isinstance(status, Status) else Status.RUNNING

    return FunctionApp(step)


def drive_then_raise(error: BaseException) -> FunctionApp:
    def fail(robot: Robot) -> None:
        raise error

    return drive_then(fail)
