"""An app that turns and reads its sensors for a time, and prints a line after its first ticks."""

from __future__ import annotations

import sys
from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Status

BEGUN = "driving"
FIRST_TICKS = 3


@dataclass
class Driving(Behaviour):
    """Turns on the spot for ``duration_s`` seconds, and reads all sensors in each tick."""

    duration_s: float = 60.0
    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})

    def __post_init__(self) -> None:
        self._ticks = 0

    def step(self, robot: Robot) -> Status:
        self._ticks += 1
        if self._ticks == FIRST_TICKS:
            print(BEGUN, file=sys.stderr, flush=True)
        robot.camera.read()
        robot.range.read()
        robot.drive.set_velocity(0.0, 0.6 if self._ticks % 2 else 0.5)
        return Status.SUCCESS if robot.clock.now() >= self.duration_s else Status.RUNNING
