"""The interface of observers, and the description of a run that they get."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from robotcore.description import RobotDescription, WorldDescription
from robotcore.hal.robot import Robot
from robotcore.hal.truth import Truth
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.faults import PlannedFault
from robotcore.runtime.operator_input import OperatorInput
from robotcore.runtime.pace import PaceControl
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.tick_statistics import TickStatistics
from robotcore.runtime.trace import TickRecord
from robotcore.safety.latch import EmergencyStop

__all__ = ["Observer", "RunContext"]


@dataclass(frozen=True)
class RunContext:
    """The parts of a run, for its observers.

    An observer must not read devices, because a read changes the run. The attribute ``latest`` of a sensor is the last
    sample that the app read.

    >>> from robotcore import RunRequest, run
    >>> class Place:
    ...     def begin(self, run: RunContext) -> None:
    ...         print(run.robot.name, run.world.name, run.truth.contacts)
    ...
    ...     def tick(self, record) -> None: ...
    ...
    ...     def end(self, result) -> None: ...
    >>> result = run(RunRequest("avoid-obstacles", settings={"duration_s": 0.1}), [Place()])
    rover arena 0
    """

    request: RunRequest
    behaviour: Behaviour
    description: RobotDescription
    world: WorldDescription | None
    robot: Robot
    """The robot as the app gets it."""
    truth: Truth | None
    """The true state of the simulator. None if the backend has none, or if the run has no world."""
    emergency: EmergencyStop
    """The emergency stop, which any thread may press."""
    faults: Sequence[PlannedFault] = ()
    """The injected faults. ``is_active(time)`` of a fault returns whether it is active."""
    operator: OperatorInput | None = None
    """The input of the person who may drive in place of the app. None if the request has no operator."""
    statistics: TickStatistics = field(default_factory=TickStatistics)
    """The durations of the ticks so far."""
    pace: PaceControl | None = None
    """The pace of simulated time. None on a real robot, and in a simulator whose time passes by itself."""
    count_overruns: Callable[[], int] = lambda: 0
    """Returns the number of ticks so far that took longer than their period."""
    add_note: Callable[[str], None] = lambda _note: None
    """Adds a note to the result, and writes it on stderr. Any thread may call it."""


class Observer(Protocol):
    """The interface of observers. A run calls its methods at the beginning, after each tick, and at the end.

    >>> from robotcore import RunRequest, run
    >>> class Speeds:
    ...     def begin(self, run):
    ...         self.sent = []
    ...
    ...     def tick(self, record):
    ...         self.sent.append(record.sent)
    ...
    ...     def end(self, result):
    ...         print(f"{result.outcome.value} after {len(self.sent)} ticks")
    >>> result = run(RunRequest("avoid-obstacles", settings={"duration_s": 0.1}), [Speeds()])
    success after 3 ticks
    """

    def begin(self, run: RunContext) -> None:
        """Receive the description of the run, before the first tick."""

    def tick(self, record: TickRecord) -> None:
        """Receive the record of a tick."""

    def end(self, result: RunResult) -> None:
        """Receive the result of the run. After a hang of an app or a driver, another thread calls this method."""


def notify_end(observers: Sequence[Observer], result: RunResult) -> list[Exception]:
    """Call `Observer.end` of every observer, even if one raises. Return the exceptions."""
    failures = []
    for observer in observers:
        try:
            observer.end(result)
        except Exception as failure:  # noqa: BLE001, PERF203  the other observers must get the result too
            failures.append(failure)
    return failures
