"""An app that causes every kind of event for a few ticks, and has several ends."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Status
from robotcore.errors import DeviceError


@dataclass
class IrregularApp(Behaviour):
    """An app whose setting ``end`` is ``success``, ``nan``, ``swallowed`` (it catches the NaN error) or ``crash``."""

    end: str = "success"
    ticks: int = 8
    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE, Role.DISPLAY})
    milestones = ("half",)

    def step(self, robot: Robot) -> Status:
        self.ticks -= 1
        self.state = "half" if self.ticks < 5 else "start"
        with suppress(DeviceError):
            robot.display.show(robot.camera.read().grey)
        robot.range.read()
        robot.drive.set_velocity(0.3, 0.1)
        if self.ticks % 3 == 0:
            robot.drive.stop()
        robot.drive.set_wheels(-0.1, robot.drive.max_angular)
        return self._end(robot) if self.ticks == 0 else Status.RUNNING

    def _end(self, robot: Robot) -> Status:
        if self.end == "crash":
            raise KeyError("left")
        if self.end == "nan":
            robot.drive.set_wheels(math.nan, math.inf)
        if self.end == "swallowed":
            with suppress(Exception):
                robot.drive.set_wheels(math.inf, -0.0)
        return Status.SUCCESS
