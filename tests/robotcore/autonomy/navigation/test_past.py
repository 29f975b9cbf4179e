from __future__ import annotations

import pytest

from robotcore.autonomy.navigation.past import KEPT_S, Past
from robotcore.geometry import Pose


@pytest.fixture
def past() -> Past:
    past = Past()
    for tick in range(100):
        past.note(tick / 20, Pose(tick / 100, 0.0, tick / 10))
    return past


def test_between_two_poses_it_is_on_the_straight_line(past: Past) -> None:
    assert past.at(4.0 + 0.0125) == pytest.approx((0.8025, 0.0, 8.025))


def test_a_pose_that_was_noted_is_given_back_to_the_bit(past: Past) -> None:
    assert past.at(99 / 20) == Pose(99 / 100, 0.0, 99 / 10)
    assert past.at(80 / 20) == Pose(80 / 100, 0.0, 80 / 10)


def test_beyond_what_is_known_it_is_the_nearest(past: Past) -> None:
    assert past.at(100.0).heading == 9.9
    assert past.at(0.0) == past.at(99 / 20 - KEPT_S)
