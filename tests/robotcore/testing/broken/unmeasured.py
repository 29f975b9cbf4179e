"""Robots without truth, whose pose the suite measures, or whose encoders alone measure the motion."""

from __future__ import annotations

from drivers.kinematic.backend import KinematicBackend
from robotcore.description import RobotDescription, load_robot
from robotcore.geometry import Pose
from robotcore.hal.backend import Capability, Setup
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite
from tests.robotcore.testing.broken.devices import scale_angles
from tests.robotcore.testing.broken.motors import change_apply, scale
from tests.robotcore.testing.harness import broken, replace_attribute

drive_backward = change_apply(scale(-1.0))


class NoTruthBackend(KinematicBackend):
    """A backend that reports no truth."""

    capabilities = frozenset({Capability.LOCKSTEP})


class NoTruthSuite(ConformanceSuite):
    """The suite on a robot without truth. Its encoders measure its motion."""

    backend = NoTruthBackend

    def open(self, setup: Setup) -> Robot:
        robot = super().open(setup)
        assert robot.truth
        self.read_outside, robot.truth = robot.truth.pose, None
        return robot


class MeasuredSuite(NoTruthSuite):
    """The suite on a robot without truth, whose pose the suite measures."""

    def measure_pose(self, robot: Robot) -> Pose:
        return self.read_outside()


def remove_encoders(robot: RobotDescription) -> RobotDescription:
    """Return the robot without its encoders."""
    assert robot.drive
    drive = robot.drive.model_copy(update={"left_encoder": None, "right_encoder": None})
    devices = tuple(device for device in robot.devices if device.kind != "encoder")
    return robot.model_copy(update={"drive": drive, "devices": devices})


ROVER_WITHOUT_ENCODERS = remove_encoders(load_robot("rover"))


class UnmeasuredSuite(NoTruthSuite):
    """The suite on a robot whose motion nothing measures."""

    @property
    def description(self) -> RobotDescription:
        return ROVER_WITHOUT_ENCODERS


class MeasuredWithoutEncodersSuite(MeasuredSuite):
    """The suite on a robot whose motion only the suite measures."""

    @property
    def description(self) -> RobotDescription:
        return ROVER_WITHOUT_ENCODERS


def reverse_motors_and_encoders(robot: Robot) -> None:
    drive_backward(robot)
    scale_angles(-1.0)(robot)


def lose_commands_while_closing(robot: Robot) -> None:
    """Let the motors take their last command in close(), and send it to no wheel."""
    close = robot.close
    closings: list[bool] = []

    def close_at_once() -> None:
        closings.append(True)
        close()

    replace_attribute(robot, "close", close_at_once)
    change_apply(lambda apply: lambda rad_s: None if closings else apply(rad_s))(robot)


BROKEN = (
    broken(
        "the stop of close() stays in a queue",
        "closing_brings_the_wheels_to_rest",
        lose_commands_while_closing,
        suite=MeasuredSuite,
    ),
    broken(
        "a measured robot without encoders drives backward",
        "positive_velocity_drives_forward left_motor_faster_turns_right wheels_turn_at_the_commanded_velocity",
        drive_backward,
        suite=MeasuredWithoutEncodersSuite,
    ),
    broken(
        "a measured robot has reversed motors and encoders",
        "positive_velocity_drives_forward left_motor_faster_turns_right wheels_turn_at_the_commanded_velocity "
        "pose_moves_as_the_wheels_roll",
        reverse_motors_and_encoders,
        suite=MeasuredSuite,
    ),
)
