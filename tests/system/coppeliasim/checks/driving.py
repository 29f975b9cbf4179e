"""Wheels roll as they are told: against the closed form, within a hundredth."""

from __future__ import annotations

import math

import pytest

from robotcore.description import load_robot
from robotcore.geometry import Pose
from robotcore.robot import Robot
from robotcore.testing import scenes
from tests.system.coppeliasim.server import opened

RATE_HZ = 20
SETTLING_TICKS = 20
WITHIN = 0.01

DRIVE = load_robot("rover").drive
assert DRIVE
RADIUS_M, TRACK_M = DRIVE.wheel_radius_m, DRIVE.track_m


def driven(left: float, right: float, seconds: float, rate_hz: float = RATE_HZ) -> tuple[float, float, float, Robot]:
    """Return how far it went ahead and to the left, in metres, how far it turned, in radians, and the closed robot."""
    with opened(scenes.empty(), "left_motor", "right_motor", rate_hz=rate_hz) as robot:
        truth = robot.truth
        assert truth
        start, turned, ticks = truth.pose(), 0.0, round(seconds * rate_hz)
        heading = start.heading
        for name, velocity in (("left_motor", left), ("right_motor", right)):
            robot.motors[name].set_velocity(velocity)
        for tick in range(ticks + SETTLING_TICKS):
            if tick == ticks:
                robot.stop()
            robot.clock.sleep_until((tick + 1) / rate_hz)
            pose: Pose = truth.pose()
            turned += math.remainder(pose.heading - heading, math.tau)
            heading = pose.heading
        assert truth.contacts() == 0
        return (*start.to_local(pose.x, pose.y), turned, robot)


@pytest.mark.parametrize("speed", [3.0, 10.0, -6.0])
def test_straight_ahead_goes_as_far_as_the_wheels_roll(speed: float) -> None:
    seconds = round(1 / abs(speed * RADIUS_M) * RATE_HZ) / RATE_HZ
    ahead, aside, turned, _ = driven(speed, speed, seconds)
    assert ahead == pytest.approx(speed * RADIUS_M * seconds, rel=WITHIN)
    assert (abs(aside) < 0.02, abs(turned) < 0.02) == (True, True), f"{aside:.4f} m aside, turned by {turned:.4f} rad"


@pytest.mark.parametrize("speed", [2.0, 8.0, -4.0])
def test_whole_turn_comes_back(speed: float) -> None:
    rate = 2 * speed * RADIUS_M / TRACK_M
    seconds = round(math.tau / abs(rate) * RATE_HZ) / RATE_HZ
    ahead, aside, turned, _ = driven(-speed, speed, seconds)
    assert turned == pytest.approx(rate * seconds, rel=WITHIN)
    assert math.hypot(ahead, aside) < 0.01


@pytest.mark.parametrize("rate_hz", [10.0, 50.0])
def test_other_rates_roll_as_well(rate_hz: float) -> None:
    ahead, _, _, _ = driven(6.0, 6.0, 3.0, rate_hz)
    assert ahead == pytest.approx(6.0 * RADIUS_M * 3.0, rel=WITHIN)


def test_robot_that_stands_does_not_creep() -> None:
    ahead, aside, turned, _ = driven(0.0, 0.0, 5.0)
    assert max(abs(ahead), abs(aside)) < 0.001
    assert abs(turned) < 0.01
