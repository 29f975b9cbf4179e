"""Suites for a variant of a driver: the conformance rules on which the variant has an influence.

The whole `ConformanceSuite` tests each driver once.
"""

from __future__ import annotations

import pytest

from robotcore.description import Mount, RobotDescription, load_robot
from robotcore.kinds.bumper import BumperDescription
from robotcore.kinds.button import ButtonDescription
from robotcore.kinds.buzzer import BuzzerDescription
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.gamepad import GamepadDescription
from robotcore.kinds.imu import ImuDescription
from robotcore.kinds.led import LedDescription
from robotcore.kinds.lidar import LidarDescription
from robotcore.kinds.line_sensor import LineSensorDescription
from robotcore.kinds.servo import ServoDescription
from robotcore.testing.bench import TestBench
from robotcore.testing.device_rules import EncoderRules
from robotcore.testing.kind_rules import KindRules
from robotcore.testing.lifecycle_rules import LifecycleRules
from robotcore.testing.motor_rules import MotorRules
from robotcore.testing.range_rules import RangeRules
from robotcore.testing.simulation_rules import RepeatRules, TruthRules


@pytest.mark.conformance
class DriveSuite(MotorRules, EncoderRules):
    """The rules for motors and encoders."""


class DriveAndRangeSuite(DriveSuite, RangeRules):
    """The rules for motors, encoders and range sensors."""


class DriveInSimulatorSuite(DriveSuite, LifecycleRules, TruthRules, RepeatRules):
    """The rules for a simulated robot with a drive of another kind."""


class SkidInSimulatorSuite(DriveInSimulatorSuite):
    """The rules for a simulated robot whose wheels skid, with an encoder on each wheel."""

    @property
    def description(self) -> RobotDescription:
        robot = load_robot("freenove-4wd")
        assert robot.drive
        left, right = (
            [name.replace("motor", "encoder") for name in names]
            for names in (robot.drive.left_motors, robot.drive.right_motors)
        )
        encoders = (EncoderDescription(kind="encoder", name=name, counts_per_turn=960) for name in (*left, *right))
        drive = robot.drive.model_copy(update={"left_encoder": tuple(left), "right_encoder": tuple(right)})
        return robot.model_copy(update={"drive": drive, "devices": (*robot.devices, *encoders)})


EQUIPMENT = (
    BumperDescription(kind="bumper", name="front"),
    ButtonDescription(kind="button", name="start"),
    BuzzerDescription(kind="buzzer", name="horn"),
    GamepadDescription(kind="gamepad", name="pad"),
    ImuDescription(kind="imu", name="imu"),
    LedDescription(kind="led", name="lamp"),
    LidarDescription(kind="lidar", name="scanner", mount=Mount(z_m=0.1), min_range_m=0.1, max_range_m=8.0, count=8),
    LineSensorDescription(kind="line_sensor", name="row", mount=Mount(x_m=0.1, z_m=0.01), count=3, spacing_m=0.01),
    ServoDescription(kind="servo", name="pan", min_angle_rad=-1.0, max_angle_rad=1.5, max_velocity_rad_s=5.0),
)
"""A device of each kind that the shipped rover does not have."""


class EquippedBench(TestBench):
    """A test bench whose robot has devices of all kinds."""

    @property
    def description(self) -> RobotDescription:
        rover = load_robot("rover")
        return rover.model_copy(update={"devices": (*rover.devices, *EQUIPMENT)})


@pytest.mark.conformance
class EquippedSuite(EquippedBench, KindRules):
    """The rules for devices of every kind."""
