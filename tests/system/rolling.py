"""Drive the rover straight and in turns, and compare its motion with the closed form, within one percent."""

from __future__ import annotations

import math
from typing import NamedTuple

import pytest

from robotcore.description import load_robot
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot

MOTORS = ("left_motor", "right_motor")
RATE_HZ = 20
SETTLING_TICKS = 20
WITHIN = 0.01

DRIVE = load_robot("rover").drive
assert DRIVE
RADIUS_M, TRACK_M = DRIVE.wheel_radius_m, DRIVE.track_m


class Motion(NamedTuple):
    """A motion in the frame of its start."""

    ahead: float
    """In metres."""

    aside: float
    """To the left, in metres."""

    turned: float
    """Counter-clockwise, in radians."""


def metre_s(speed: float) -> float:
    """Return the time for a metre, in seconds, rounded to whole ticks; ``speed`` is the wheels', in rad/s."""
    return round(1 / abs(speed * RADIUS_M) * RATE_HZ) / RATE_HZ


def turn_s(speed: float) -> float:
    """Return the time for a whole turn, in seconds, rounded to whole ticks; ``speed`` is the wheels', in rad/s."""
    return round(math.tau / abs(_turning(speed)) * RATE_HZ) / RATE_HZ


def drive(robot: Robot, left: float, right: float, seconds: float, rate_hz: float = RATE_HZ) -> Motion:
    """Drive a robot that has just been opened, let it come to rest, and return its motion.

    left, right: the wheels' velocities in rad/s.
    """
    truth = robot.truth
    assert truth
    start, turned, ticks = truth.pose(), 0.0, round(seconds * rate_hz)
    heading = start.heading
    for name, velocity in zip(MOTORS, (left, right), strict=True):
        robot.motors[name].set_velocity(velocity)
    for tick in range(ticks + SETTLING_TICKS):
        if tick == ticks:
            robot.stop()
        robot.clock.sleep_until((tick + 1) / rate_hz)
        pose: Pose = truth.pose()
        turned += math.remainder(pose.heading - heading, math.tau)
        heading = pose.heading
    assert truth.contacts() in {0, None}
    return Motion(*start.to_local(pose.x, pose.y), turned)


def require_straight(motion: Motion, speed: float) -> None:
    ahead, aside, turned = motion
    assert ahead == pytest.approx(speed * RADIUS_M * metre_s(speed), rel=WITHIN)
    assert (abs(aside) < 0.02, abs(turned) < 0.02) == (True, True), f"{aside:.4f} m aside, turned by {turned:.4f} rad"


def require_turn(motion: Motion, speed: float) -> None:
    assert motion.turned == pytest.approx(_turning(speed) * turn_s(speed), rel=WITHIN)
    assert math.hypot(motion.ahead, motion.aside) < 0.01


def _turning(speed: float) -> float:
    return 2 * speed * RADIUS_M / TRACK_M
