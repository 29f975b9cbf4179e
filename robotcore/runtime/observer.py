"""Observers of a run, and the view of the run that they get."""

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
    """A run as an observer gets it. An observer must not read devices, because that would change the run.

    A device's ``latest`` has its last sample.
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
    """It stops the run, from any thread."""
    faults: Sequence[PlannedFault] = ()
    """The injected faults. Each method `is_on` says whether the fault is active at a time."""


class Observer(Protocol):
    """Gets the beginning of a run, each tick, and the result."""

    def begin(self, run: Run) -> None:
        """Take the run, before its first tick."""

    def tick(self, record: TickRecord) -> None:
        """Take the record of a tick."""

    def end(self, result: RunResult) -> None:
        """Take the result. If an app or a driver hangs and the process exits, another thread calls this."""


def notify_end(observers: Sequence[Observer], result: RunResult) -> list[Exception]:
    """Call `Observer.end` of every observer, even if one raises. Return what they raised."""
    failures = []
    for observer in observers:
        try:
            observer.end(result)
        except Exception as failure:  # noqa: BLE001, PERF203  the others get the result too
            failures.append(failure)
    return failures
