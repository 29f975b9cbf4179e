"""The backend `virtualpi` passes the conformance kit; variants pass its rules for drives and ranges."""

from __future__ import annotations

from typing import ClassVar

import pytest

from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from robotcore.description import RobotDescription
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite, TestSupport
from robotcore.testing.bench import TestBench
from tests.drivers.raspberrypi.virtual.fakes import rewire
from tests.robotcore.testing.variant_suites import DriveAndRangeSuite, DriveSuite


class VirtualBench(TestBench):
    """A test bench that can suppress the echoes of a virtual robot."""

    backend = VirtualPiBackend
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: "virtual hardware never waits"}
    is_lost = False

    def open(self, setup: Setup) -> Robot:
        return VirtualPiBackend(lambda: self.is_lost).open(setup)

    def lose_echoes(self, robot: Robot) -> None:
        self.is_lost = True


class TestVirtualPi(VirtualBench, ConformanceSuite):
    pass


@pytest.mark.usefixtures("pybullet")
class TestVirtualPiOnBullet(VirtualBench, DriveAndRangeSuite):
    options: ClassVar = {"simulator": "pybullet"}


class TestVirtualPiWiredOtherwise(VirtualBench, DriveSuite):
    """Phase-enable boards, and encoders with one channel."""

    @property
    def description(self) -> RobotDescription:
        return rewire()
