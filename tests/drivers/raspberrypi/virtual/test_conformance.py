"""The backend `virtualpi` passes the conformance kit with every simulator."""

from __future__ import annotations

from typing import ClassVar

import pytest

from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from robotcore.description import RobotDescription
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite, TestSupport
from tests.drivers.raspberrypi.virtual.fakes import rewire


class TestVirtualPi(ConformanceSuite):
    backend = VirtualPiBackend
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: "virtual hardware never waits"}
    is_lost = False

    def open(self, setup: Setup) -> Robot:
        return VirtualPiBackend(lambda: self.is_lost).open(setup)

    def lose_echoes(self, robot: Robot) -> None:
        self.is_lost = True


@pytest.mark.usefixtures("pybullet")
class TestVirtualPiOnBullet(TestVirtualPi):
    options: ClassVar = {"simulator": "pybullet"}


class TestVirtualPiWiredOtherwise(TestVirtualPi):
    """Phase-enable boards, and encoders with one channel."""

    @property
    def description(self) -> RobotDescription:
        return rewire()
