"""Wheels roll as they are told: against the closed form, within a hundredth."""

from __future__ import annotations

import pytest

from robotcore.testing import worlds
from tests.system import rolling
from tests.system.coppeliasim.server import opened
from tests.system.rolling import RADIUS_M, RATE_HZ, WITHIN, Rolled


def driven(left: float, right: float, seconds: float, rate_hz: float = RATE_HZ) -> Rolled:
    with opened(worlds.empty(), *rolling.MOTORS, rate_hz=rate_hz) as robot:
        return rolling.driven(robot, left, right, seconds, rate_hz)


@pytest.mark.parametrize("speed", [3.0, 10.0, -6.0])
def test_straight_ahead_goes_as_far_as_the_wheels_roll(speed: float) -> None:
    rolling.require_straight(driven(speed, speed, rolling.metre_s(speed)), speed)


@pytest.mark.parametrize("speed", [2.0, 8.0, -4.0])
def test_whole_turn_comes_back(speed: float) -> None:
    rolling.require_turn(driven(-speed, speed, rolling.turn_s(speed)), speed)


@pytest.mark.parametrize("rate_hz", [10.0, 50.0])
def test_other_rates_roll_as_well(rate_hz: float) -> None:
    ahead, _, _ = driven(6.0, 6.0, 3.0, rate_hz)
    assert ahead == pytest.approx(6.0 * RADIUS_M * 3.0, rel=WITHIN)


def test_robot_that_stands_does_not_creep() -> None:
    ahead, aside, turned = driven(0.0, 0.0, 5.0)
    assert max(abs(ahead), abs(aside)) < 0.001
    assert abs(turned) < 0.01
