"""Who looks at a run, and what there is to see."""

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
    """A run as an observer sees it. Reading a device here would steer the run: look at ``latest`` instead.

    ``emergency`` stops it, from any thread. ``faults`` are those on purpose; each says by `is_on` whether
    it is there at a time.
    """

    request: RunRequest
    behaviour: Behaviour
    description: RobotDescription
    world: WorldDescription | None
    robot: Robot
    truth: Truth | None
    emergency: EmergencyStop
    faults: Sequence[PlannedFault] = ()


class Observer(Protocol):
    """Looks at a run: from its first tick, at each, and at its result.

    Where the process ends itself, because an app or a driver does not come back, `end` is called from another thread.
    """

    def begin(self, run: Run) -> None: ...
    def tick(self, record: TickRecord) -> None: ...
    def end(self, result: RunResult) -> None: ...
