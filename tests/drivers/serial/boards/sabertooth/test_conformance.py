"""Motors on a Sabertooth keep the kit's rules; how they turn is seen on the wheels, for the board does not tell."""

from __future__ import annotations

from typing import ClassVar

from robotcore.geometry import Wheels
from robotcore.hal.drive import Odometry
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite
from robotcore.testing.bench import Motion, let_pass, motion_between
from tests.doubles.serial.board import BoardDouble
from tests.doubles.serial.sabertooth import Sabertooths
from tests.doubles.serial.ticking import TickingBench

FULL_RAD_S = 16.0
MODEL = {"forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S}


class TestSabertooth(TickingBench, ConformanceSuite):
    devices: ClassVar = {
        "left_motor": {"driver": "sabertooth-motor", "motor": 1, "model": MODEL},
        "right_motor": {"driver": "sabertooth-motor", "motor": 2, "model": MODEL},
    }

    def board(self) -> BoardDouble:
        self.line = Sabertooths(full_rad_s=FULL_RAD_S)
        return self.line

    def motion(self, robot: Robot, seconds: float) -> Motion:
        where = Odometry(self.drive.geometry, self._wheels).pose
        before = where()
        let_pass(robot, seconds)
        return motion_between(before, where())

    def _wheels(self) -> Wheels:
        wheels = self.line.boards[128].wheels
        return Wheels(wheels.left.angle, wheels.right.angle)
