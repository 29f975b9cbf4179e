"""The speed profile, the path and the pose tracker."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from robotcore.autonomy.manoeuvres.path import Path, Piece
from robotcore.autonomy.manoeuvres.speed_profile import CoastingEstimator, SpeedProfile
from robotcore.geometry import Pose

PERIOD = 0.05
PROFILE = SpeedProfile(top=0.2, acceleration=0.5, slowest=0.01)


@pytest.mark.parametrize("distance", [1.0, -1.0, 0.03, 0.0004])
def test_profile_ends_exactly_without_overshoot(distance: float) -> None:
    position = last = 0.0
    for _ in range(1000):
        last = PROFILE.compute_speed(distance - position, last, PERIOD) if position != distance else 0.0
        position += last * PERIOD
        assert abs(position) <= abs(distance) + 1e-12
    assert position == pytest.approx(distance, abs=1e-9)


def test_profile_keeps_its_limits() -> None:
    position, speeds = 0.0, [0.0]
    while abs(1.0 - position) > 1e-6:
        speeds.append(PROFILE.compute_speed(1.0 - position, speeds[-1], PERIOD))
        position += speeds[-1] * PERIOD
    assert max(speeds) == PROFILE.top
    changes = [after - before for before, after in pairwise(speeds)]
    assert max(changes) == pytest.approx(PROFILE.acceleration * PERIOD)
    assert min(changes) > -PROFILE.acceleration * PERIOD - 1e-9


def test_coasting_is_the_way_of_a_first_order_lag() -> None:
    coasting = CoastingEstimator(0.1)
    coasting.add_command(2.0, 100.0)
    assert coasting.way == pytest.approx(0.2)
    coasting.add_command(0.0, 0.1)
    assert coasting.way == pytest.approx(0.2 / math.e)


def test_without_a_lag_there_is_no_coasting() -> None:
    coasting = CoastingEstimator(0.0)
    coasting.add_command(2.0, 1.0)
    assert coasting.way == 0.0


def test_place_beside_a_chain_of_a_line_and_an_arc() -> None:
    line = Piece(Pose(1.0, 0.0, math.pi / 2), 2.0)
    bend = Piece(line.end, math.pi / 2, 1.0)
    path = Path([line, bend])
    assert path.length == pytest.approx(2.0 + math.pi / 2)
    assert path.end == pytest.approx((0.0, 3.0, math.pi))
    place = path.locate(Pose(1.1, 0.5, math.pi / 2 - 0.2), 0.4)
    assert place == pytest.approx((0.5, -0.1, -0.2, 0.0))
    outside = Pose(1.1 * math.cos(0.3), 2.0 + 1.1 * math.sin(0.3), math.pi / 2 + 0.3)
    assert path.locate(outside, 2.2) == pytest.approx((2.3, -0.1, 0.0, 1.0), abs=1e-3)


def test_progress_backward_and_beyond_the_end() -> None:
    path = Path([Piece(Pose(0.0, 0.0, 0.0), -1.0)])
    assert path.locate(Pose(-1.2, 0.1, 0.0), -0.9) == pytest.approx((-1.2, 0.1, 0.0, 0.0))
