"""The interface of observers, and the description of a run that they get."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from robotcore.description import RobotDescription, WorldDescription
from robotcore.hal.robot import Robot
from robotcore.hal.truth import Truth
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.faults import PlannedFault
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.safety import EmergencyStop


@dataclass(frozen=True)
class Run:
    """The description of a run that an observer gets.

    An observer must not read devices, because that would change the run. It uses the attribute ``latest`` of a sensor,
    which is the last sample that the app read.
    """

    request: RunRequest
    behaviour: Behaviour
    description: RobotDescription
    world: WorldDescription | None
    robot: Robot
    """The robot as the app gets it."""
    truth: Truth | None
    """The simulator's truth; None if the backend has none, or no world was named."""
    emergency: EmergencyStop
    """The emergency stop, which any thread may press."""
    faults: Sequence[PlannedFault] = ()
    """The injected faults. The method `is_on` of a fault returns whether it is active at a time."""


class Observer(Protocol):
    """The base class of observers. A run calls its methods at the beginning, after each tick, and at the end."""

    def begin(self, run: Run) -> None:
        """Receive the description of the run, before the first tick."""

    def tick(self, record: TickRecord) -> None:
        """Receive the record of a tick."""

    def end(self, result: RunResult) -> None:
        """Receive the result of the run. If an app or a driver hangs, another thread than before calls this method."""


def notify_end(observers: Sequence[Observer], result: RunResult) -> list[Exception]:
    """Call `Observer.end` of every observer, even if one raises. Return the exceptions that they raised."""
    failures = []
    for observer in observers:
        try:
            observer.end(result)
        except Exception as failure:  # noqa: BLE001, PERF203  the other observers must get the result too
            failures.append(failure)
    return failures
