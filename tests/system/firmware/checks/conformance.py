"""The kit's rules, on the drivers that ship and a firmware that runs."""

from __future__ import annotations

from typing import ClassVar

from robotcore.description import RobotDescription
from robotcore.robot import Robot
from robotcore.testing import Capability, ConformanceSuite
from tests.system.firmware.backend import SimavrBackend
from tests.system.firmware.described import with_battery
from tests.system.firmware.world import FollowedWorld


class TestOnTheFirmware(ConformanceSuite):
    """Some rules tell the wheels once, and look on for 2.5 s: for so long the board's own deadman has to wait."""

    backend = SimavrBackend
    options: ClassVar = {"board_timeout_s": 5.0}
    lacks: ClassVar = {
        Capability.SLOW_HARDWARE: "the firmware answers, or it does not; tests/drivers/serial has a gate"
    }

    @property
    def description(self) -> RobotDescription:
        return with_battery()

    def lose_echoes(self, robot: Robot) -> None:
        assert isinstance(robot.truth, FollowedWorld)
        robot.truth.fall_silent()
