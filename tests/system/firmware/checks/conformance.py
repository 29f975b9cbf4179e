"""The kit's rules, on the drivers that ship and a firmware that runs."""

from __future__ import annotations

from typing import ClassVar

from robotcore.robot import Robot
from robotcore.testing import Capability, ConformanceSuite
from tests.system.firmware.backend import SimavrBackend
from tests.system.firmware.world import FollowedWorld


class TestOnTheFirmware(ConformanceSuite):
    backend = SimavrBackend
    lacks: ClassVar = {
        Capability.SLOW_HARDWARE: "the firmware answers, or it does not; tests/drivers/serial has a gate"
    }

    def lose_echoes(self, robot: Robot) -> None:
        assert isinstance(robot.truth, FollowedWorld)
        robot.truth.is_silent = True
