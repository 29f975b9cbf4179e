from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.description import Mount
from robotcore.geometry import Pose
from robotcore.optics import CameraView, Intrinsics

INTRINSICS = Intrinsics(320, 240, math.radians(90))
ORIGIN = Pose(0.0, 0.0, 0.0)


def view(pose: Pose = ORIGIN, **mount: Any) -> CameraView:
    return CameraView.of(INTRINSICS, Mount(z_m=0.5, **mount), pose)


def pixel(seen: CameraView, *point: float) -> tuple[float, float]:
    u, v = seen.to_pixels(seen.to_camera(np.array([point])))[0]
    return float(u), float(v)


def test_point_straight_ahead_is_in_the_middle() -> None:
    assert pixel(view(), 2.0, 0.0, 0.5) == pytest.approx((159.5, 119.5))


def test_point_to_the_left_is_left_and_point_above_is_higher() -> None:
    assert pixel(view(), 2.0, 1.0, 1.5) == pytest.approx((159.5 - 80, 119.5 - 80))


def test_point_at_twice_the_distance_is_half_as_far_from_the_middle() -> None:
    assert pixel(view(), 4.0, 1.0, 0.5) == pytest.approx((159.5 - 40, 119.5))


def test_a_camera_that_looks_down_sees_the_floor_in_the_middle() -> None:
    assert pixel(view(pitch_rad=math.pi / 4), 0.5, 0.0, 0.0) == pytest.approx((159.5, 119.5))


def test_the_eye_moves_and_turns_with_the_robot_and_its_mount() -> None:
    seen = view(Pose(1.0, 2.0, math.pi / 2), x_m=0.1, yaw_rad=math.pi / 2)
    assert seen.eye == pytest.approx([1.0, 2.1, 0.5])
    assert pixel(seen, -3.0, 2.1, 0.5) == pytest.approx((159.5, 119.5))


@given(st.floats(-6, 6), st.floats(-1.5, 1.5), st.floats(0.1, 5), st.floats(-2, 2), st.floats(-1, 1))
def test_bearing_of_a_column_is_the_direction_of_its_points(
    heading: float, yaw: float, ahead: float, left: float, up: float
) -> None:
    seen = view(Pose(0.3, -0.2, heading), yaw_rad=yaw)
    eye = Pose(float(seen.eye[0]), float(seen.eye[1]), heading + yaw)
    u, _ = pixel(seen, *eye.to_world(ahead, left), 0.5 + up)
    assert INTRINSICS.bearing(u) == pytest.approx(math.atan2(left, ahead), abs=1e-9)


def test_rotation_keeps_lengths_and_handedness() -> None:
    rotation = view(Pose(0, 0, 0.7), yaw_rad=0.2, pitch_rad=0.3).rotation
    assert rotation @ rotation.T == pytest.approx(np.eye(3))
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_a_point_is_shown_within_the_edges_of_the_picture() -> None:
    for point, is_shown in [
        ((2.0, 0.0, 0.5), True),
        ((2.0, 1.99, 0.5), True),
        ((2.0, 2.01, 0.5), False),
        ((2.0, -2.01, 0.5), False),
        ((2.0, 0.0, 1.99), True),
        ((2.0, 0.0, 2.01), False),
        ((2.0, 0.0, -1.01), False),
        ((-2.0, 0.0, 0.5), False),
        ((0.0, 0.0, 0.5), False),
    ]:
        assert view().shows(np.array([point])).tolist() == [is_shown], point
