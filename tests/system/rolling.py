"""How far the rover goes, and how far its wheels roll by the closed form: within a hundredth."""

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


class Rolled(NamedTuple):
    """How far it went ahead and to the left, in metres, and how far it turned, in radians."""

    ahead: float
    aside: float
    turned: float


def metre_s(speed: float) -> float:
    """Return how long a metre takes, in whole ticks."""
    return round(1 / abs(speed * RADIUS_M) * RATE_HZ) / RATE_HZ


def turn_s(speed: float) -> float:
    """Return how long a whole turn takes, in whole ticks."""
    return round(math.tau / abs(_turning(speed)) * RATE_HZ) / RATE_HZ


def driven(robot: Robot, left: float, right: float, seconds: float, rate_hz: float = RATE_HZ) -> Rolled:
    """Drive an open robot that has just begun, and let it come to rest."""
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
    return Rolled(*start.to_local(pose.x, pose.y), turned)


def require_straight(rolled: Rolled, speed: float) -> None:
    ahead, aside, turned = rolled
    assert ahead == pytest.approx(speed * RADIUS_M * metre_s(speed), rel=WITHIN)
    assert (abs(aside) < 0.02, abs(turned) < 0.02) == (True, True), f"{aside:.4f} m aside, turned by {turned:.4f} rad"


def require_turn(rolled: Rolled, speed: float) -> None:
    assert rolled.turned == pytest.approx(_turning(speed) * turn_s(speed), rel=WITHIN)
    assert math.hypot(rolled.ahead, rolled.aside) < 0.01


def _turning(speed: float) -> float:
    return 2 * speed * RADIUS_M / TRACK_M
