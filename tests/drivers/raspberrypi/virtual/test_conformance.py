"""The backend `virtualpi` passes the conformance kit; variants pass its rules for drives and ranges."""

from __future__ import annotations

from typing import ClassVar

import pytest

from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite, TestSupport
from robotcore.testing.bench import TestBench
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


@pytest.mark.skipif(not load_backend("pybullet").is_installed, reason="pybullet is not installed")
class TestVirtualPiOnBullet(VirtualBench, DriveAndRangeSuite):
    options: ClassVar = {"simulator": "pybullet"}


class TestVirtualPiWiredOtherwise(VirtualBench, DriveSuite):
    """Phase-enable boards, and encoders with one channel."""

    @property
    def description(self) -> RobotDescription:
        rover = load_robot("rover")
        board = {"driver": "phase-enable", "model": {"dead_band": 0.05, "forward_rad_s": 16.0, "backward_rad_s": 15.0}}
        section = rover.backends["raspberrypi"] | {
            "left_motor": {**board, "phase": 17, "enable": 27},
            "right_motor": {**board, "phase": 23, "enable": 24},
            "left_encoder": {"driver": "pulses", "gpio": 5},
            "right_encoder": {"driver": "pulses", "gpio": 20},
        }
        return rover.model_copy(update={"backends": rover.backends | {"raspberrypi": section}})


class TestVirtualPiWithPwmChip(VirtualBench, DriveSuite):
    """Motors on channels of a PCA9685: one with two inputs, one with its direction on a GPIO."""

    @property
    def description(self) -> RobotDescription:
        rover = load_robot("rover")
        chip = {"address": 0x60, "model": {"dead_band": 0.05, "forward_rad_s": 16.0, "backward_rad_s": 15.0}}
        section = rover.backends["raspberrypi"] | {
            "left_motor": {"driver": "pca9685-motor", "forward": 9, "backward": 10, "pwm": 8, **chip},
            "right_motor": {"driver": "pca9685-phase-motor", "pwm": 4, "phase": 17, **chip},
        }
        return rover.model_copy(update={"backends": rover.backends | {"raspberrypi": section}})
