"""The backend `virtualpi` passes the conformance kit; variants pass its rules for drives and ranges."""

from __future__ import annotations

from typing import Any, ClassVar

import pytest

from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite, TestSupport
from robotcore.testing.bench import TestBench
from robotcore.testing.lifecycle_rules import LifecycleRules
from robotcore.testing.simulation_rules import TruthRules
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


BOARD = {"driver": "h-bridge", "model": {"dead_band": 0.05, "forward_rad_s": 16.0, "backward_rad_s": 16.0}}


class DriveKindSuite(VirtualBench, DriveSuite, LifecycleRules, TruthRules):
    """The rules on which the kind of the drive has an influence."""


class TestVirtualPiThatSkids(DriveKindSuite):
    """Four H-bridges, and an encoder on the first wheel of each side."""

    @property
    def description(self) -> RobotDescription:
        robot = load_robot("freenove-4wd")
        assert robot.drive
        pins = iter(range(4, 14))
        section: dict[str, Any] = {
            name: {**BOARD, "forward": next(pins), "backward": next(pins)} for name in robot.drive.motors
        }
        encoders = {"left_encoder": "left_slots", "right_encoder": "right_slots"}
        for name in encoders.values():
            section[name] = {"driver": "pulses", "gpio": next(pins)}
        return RobotDescription.model_validate(
            {
                **robot.model_dump(),
                "drive": {**robot.drive.model_dump(), **encoders},
                "devices": [
                    *(device.model_dump() for device in robot.devices if device.kind == "motor"),
                    *({"kind": "encoder", "name": name, "counts_per_turn": 960} for name in encoders.values()),
                ],
                "backends": {"raspberrypi": section},
            }
        )


class TestVirtualPiThatSteers(DriveKindSuite):
    """Two H-bridges, an encoder on each wheel, and a servo."""

    @property
    def description(self) -> RobotDescription:
        robot = load_robot("picar")
        section = {
            "left_motor": {**BOARD, "forward": 17, "backward": 27},
            "right_motor": {**BOARD, "forward": 23, "backward": 24},
            "left_encoder": {"driver": "quadrature", "a": 5, "b": 6},
            "right_encoder": {"driver": "quadrature", "a": 20, "b": 21},
            "steering": {"driver": "servo", "gpio": 12},
        }
        devices = tuple(device for device in robot.devices if device.name in section)
        return robot.model_copy(update={"devices": devices, "backends": {"raspberrypi": section}})
