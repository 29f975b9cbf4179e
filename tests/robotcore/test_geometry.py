from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.geometry import Pose, wrap_angle

ORIGIN = Pose(0.0, 0.0, 0.0)

metres = st.floats(-100, 100)
angles = st.floats(-20, 20)
poses = st.builds(Pose, metres, metres, angles)


def test_straight_motion_keeps_the_heading() -> None:
    assert Pose(1.0, 2.0, math.pi / 2).advance(3.0, 0.0) == pytest.approx((1.0, 5.0, math.pi / 2))


def test_a_quarter_circle_to_the_left_ends_a_radius_ahead_and_a_radius_to_the_left() -> None:
    radius = 2.0
    assert ORIGIN.advance(radius * math.pi / 2, math.pi / 2) == pytest.approx((radius, radius, math.pi / 2))


def test_a_full_circle_ends_where_it_began() -> None:
    assert ORIGIN.advance(5.0, math.tau) == pytest.approx((0.0, 0.0, math.tau), abs=1e-12)


def test_a_turn_on_the_spot_moves_nothing() -> None:
    assert Pose(1.0, 2.0, 0.5).advance(0.0, 1.0) == (1.0, 2.0, 1.5)


@given(poses, st.floats(-10, 10), st.floats(-6, 6), st.integers(1, 20))
def test_an_arc_in_parts_ends_where_the_whole_arc_ends(pose: Pose, distance: float, turn: float, parts: int) -> None:
    stepped = pose
    for _ in range(parts):
        stepped = stepped.advance(distance / parts, turn / parts)
    assert stepped == pytest.approx(pose.advance(distance, turn), abs=1e-9)


@given(poses, st.floats(-10, 10), st.floats(-6, 6))
def test_an_arc_driven_backwards_leads_back(pose: Pose, distance: float, turn: float) -> None:
    assert pose.advance(distance, turn).advance(-distance, -turn) == pytest.approx(pose, abs=1e-9)


@given(st.floats(1e-15, 1e-9))
def test_tiny_turn_is_continuous_with_straight_motion(turn: float) -> None:
    assert ORIGIN.advance(1.0, turn)[:2] == pytest.approx((1.0, 0.0), abs=1e-9)


@given(st.floats(-1e6, 1e6))
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-6)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-6)


@pytest.mark.parametrize("angle", [math.pi, -math.pi])
def test_direction_straight_backwards_is_positive(angle: float) -> None:
    assert wrap_angle(angle) == math.pi


@given(poses, metres, metres)
def test_to_local_undoes_to_world(pose: Pose, x: float, y: float) -> None:
    assert pose.to_local(*pose.to_world(x, y)) == pytest.approx((x, y), abs=1e-9)


def test_left_of_a_robot_that_looks_along_y_is_minus_x() -> None:
    assert Pose(1.0, 1.0, math.pi / 2).to_world(0.0, 2.0) == pytest.approx((-1.0, 1.0))


def test_composed_pose_moves_and_turns_with_the_robot() -> None:
    assert Pose(1.0, 0.0, math.pi / 2).compose(Pose(0.5, 0.0, 0.25)) == pytest.approx((1.0, 0.5, math.pi / 2 + 0.25))


def test_a_point_to_the_left_has_a_positive_bearing() -> None:
    pose = Pose(1.0, 1.0, 0.0)
    assert pose.bearing_to(2.0, 2.0) == pytest.approx(math.pi / 4)
    assert pose.bearing_to(2.0, 0.0) == pytest.approx(-math.pi / 4)
    assert pose.distance_to(2.0, 2.0) == pytest.approx(math.sqrt(2))


@pytest.mark.slow
@given(poses, metres, metres)
def test_driving_the_distance_along_the_bearing_reaches_the_point(pose: Pose, x: float, y: float) -> None:
    there = pose.advance(0.0, pose.bearing_to(x, y)).advance(pose.distance_to(x, y), 0.0)
    assert there[:2] == pytest.approx((x, y), abs=1e-9)
