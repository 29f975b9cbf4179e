"""The conformance kit, with the serial drivers and the firmware on a simulated AVR."""

from __future__ import annotations

from typing import ClassVar

import pytest

from robotcore.description import RobotDescription
from robotcore.hal.robot import Robot, Role
from robotcore.testing import ConformanceSuite, TestSupport
from robotcore.testing.bench import sleep
from robotcore.testing.device_rules import SPEED_RAD_S
from tests.system.firmware.backend import SimavrBackend
from tests.system.firmware.config import load_rover_with_battery
from tests.system.firmware.world import FollowedWorld


class TestOnTheFirmware(ConformanceSuite):
    """Some rules command the wheels once, and watch them for 2.5 s, so the board's time-out must be longer."""

    backend = SimavrBackend
    options: ClassVar = {"board_timeout_s": 5.0}
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: "the firmware has no slow answers; tests/drivers/serial has a gate"}

    @property
    def description(self) -> RobotDescription:
        return load_rover_with_battery()

    def test_angles_are_in_radians(self) -> None:
        """Compare by the times of the samples, because on a busy machine the newest sample is older."""
        with self.open_robot(None, Role.DRIVE) as robot:
            encoders = self.get_encoders(robot)
            self.command_wheels(robot, SPEED_RAD_S, SPEED_RAD_S)
            before = [encoder.read() for encoder in encoders]
            sleep(robot, 1.0)
            for encoder, then in zip(encoders, before, strict=True):
                now = encoder.read()
                assert (now.angle - then.angle) / (now.time - then.time) == pytest.approx(SPEED_RAD_S, rel=0.03)

    def lose_echoes(self, robot: Robot) -> None:
        assert isinstance(robot.truth, FollowedWorld)
        robot.truth.drop_echoes()
