"""The kit's rules, on the drivers that ship and a firmware that runs."""

from __future__ import annotations

from typing import ClassVar

import pytest

from robotcore.description import RobotDescription
from robotcore.hal.robot import Robot, Role
from robotcore.testing import ConformanceSuite, TestSupport
from robotcore.testing.bench import let_pass
from robotcore.testing.device_rules import SPEED_RAD_S
from tests.system.firmware.backend import SimavrBackend
from tests.system.firmware.config import with_battery
from tests.system.firmware.world import FollowedWorld


class TestOnTheFirmware(ConformanceSuite):
    """Some rules tell the wheels once, and look on for 2.5 s: for so long the board's own deadman has to wait."""

    backend = SimavrBackend
    options: ClassVar = {"board_timeout_s": 5.0}
    lacks: ClassVar = {
        TestSupport.SLOW_HARDWARE: "the firmware answers, or it does not; tests/drivers/serial has a gate"
    }

    @property
    def description(self) -> RobotDescription:
        return with_battery()

    def test_angles_are_in_radians(self) -> None:
        """By the samples' own times: a busy machine's newest one is older than a quiet machine's."""
        with self.opened(None, Role.DRIVE) as robot:
            encoders = self.encoders(robot)
            self.command(robot, SPEED_RAD_S, SPEED_RAD_S)
            before = [encoder.read() for encoder in encoders]
            let_pass(robot, 1.0)
            for encoder, then in zip(encoders, before, strict=True):
                now = encoder.read()
                assert (now.angle - then.angle) / (now.time - then.time) == pytest.approx(SPEED_RAD_S, rel=0.03)

    def lose_echoes(self, robot: Robot) -> None:
        assert isinstance(robot.truth, FollowedWorld)
        robot.truth.fall_silent()
