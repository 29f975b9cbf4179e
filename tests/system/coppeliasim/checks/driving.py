"""Check that the robot moves within 1 % of the closed form."""

from __future__ import annotations

import pytest

from robotcore.testing import worlds
from tests.system import rolling
from tests.system.coppeliasim.server import open_robot
from tests.system.rolling import RADIUS_M, RATE_HZ, WITHIN, Motion


def drive(left: float, right: float, seconds: float, rate_hz: float = RATE_HZ) -> Motion:
    with open_robot(worlds.empty(), *rolling.MOTORS, rate_hz=rate_hz) as robot:
        return rolling.drive(robot, left, right, seconds, rate_hz)


@pytest.mark.parametrize("speed", [3.0, 10.0, -6.0])
def test_straight_distance_equals_the_rolled_distance(speed: float) -> None:
    rolling.require_straight(drive(speed, speed, rolling.metre_s(speed)), speed)


@pytest.mark.parametrize("speed", [2.0, 8.0, -4.0])
def test_full_turn_returns_to_the_start(speed: float) -> None:
    rolling.require_turn(drive(-speed, speed, rolling.turn_s(speed)), speed)


@pytest.mark.parametrize("rate_hz", [10.0, 50.0])
def test_other_rates_give_the_same_distance(rate_hz: float) -> None:
    ahead, _, _ = drive(6.0, 6.0, 3.0, rate_hz)
    assert ahead == pytest.approx(6.0 * RADIUS_M * 3.0, rel=WITHIN)


def test_standing_robot_does_not_creep() -> None:
    ahead, aside, turned = drive(0.0, 0.0, 5.0)
    assert max(abs(ahead), abs(aside)) < 0.001
    assert abs(turned) < 0.01
