"""A lens distorts pictures as OpenCV's model does, and the intrinsics know where it shows a point."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from robotcore.description import Mount
from robotcore.geometry import Pose
from robotcore.lens import Lens, is_invertible
from robotcore.optics import CameraView, Intrinsics

WIDE = Intrinsics(320, 240, 1.1, (150.0, 125.0), (-0.28, 0.07, 0.002, -0.001, -0.005))
PINCUSHION = Intrinsics(160, 120, 0.9, None, (0.15, 0.02, 0.0, 0.0, 0.0))
LENSES = pytest.mark.parametrize("eye", [WIDE, PINCUSHION])


def draw_points(count: int) -> np.ndarray:
    return np.random.default_rng(4).uniform((-0.45, -0.3, 1.0), (0.45, 0.3, 1.0), (count, 3))


@LENSES
def test_points_are_shown_at_the_pixels_of_opencv(eye: Intrinsics) -> None:
    points = draw_points(50)
    f = eye.focal_length
    matrix = np.array([[f, 0, eye.cx], [0, f, eye.cy], [0, 0, 1]])
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, np.array(eye.distortion))
    view = CameraView(eye, np.zeros(3), np.eye(3))
    assert view.to_pixels(points) == pytest.approx(expected.reshape(-1, 2), abs=1e-9)


@LENSES
def test_undistort_inverts_distort_up_to_the_corners(eye: Intrinsics) -> None:
    corners = np.array([(u, v) for u in (0, eye.width - 1) for v in (0, eye.height - 1)], dtype=float)
    assert eye.distort(eye.undistort(corners)) == pytest.approx(corners, abs=1e-3)


def test_a_bearing_is_that_of_the_point_in_the_world() -> None:
    view = CameraView(WIDE, np.zeros(3), np.eye(3))
    for right, down, _ in draw_points(20):
        ((u, v),) = view.to_pixels(np.array([[right, down, 1.0]]))
        assert WIDE.bearing(u, v) == pytest.approx(math.atan2(-right, 1.0), abs=1e-6)


@LENSES
def test_the_bent_picture_of_a_pinhole_shows_points_where_the_intrinsics_say(eye: Intrinsics) -> None:
    lens = Lens(eye)
    view, flat = (CameraView(each, np.zeros(3), np.eye(3)) for each in (eye, lens.pinhole))
    for point in draw_points(30):
        image = np.zeros((lens.pinhole.height, lens.pinhole.width, 3), np.uint8)
        ((u, v),) = np.rint(flat.to_pixels(point[None])).astype(int)
        cv2.circle(image, (int(u), int(v)), 3, (255, 255, 255), -1)
        rows, columns = np.nonzero(lens.bend(image)[:, :, 0])
        expected = view.to_pixels(point[None])[0]
        if len(rows) and (expected > 5).all() and (expected < (eye.width - 5, eye.height - 5)).all():
            assert (columns.mean(), rows.mean()) == pytest.approx(tuple(expected), abs=1.5)


def test_a_pinhole_without_distortion_returns_the_picture_itself() -> None:
    image = np.zeros((240, 320, 3), np.uint8)
    lens = Lens(Intrinsics(320, 240, 1.0))
    assert lens.bend(image) is image
    assert lens.pinhole == Intrinsics(320, 240, 1.0)


def test_a_lens_that_folds_the_picture_is_not_invertible() -> None:
    assert is_invertible(WIDE)
    assert not is_invertible(Intrinsics(320, 240, 1.1, None, (-2.0, 0.0, 0.0, 0.0, 0.0)))
    assert not is_invertible(Intrinsics(320, 240, 2.9, None, (0.5, 0.0, 0.0, 0.0, 0.0)))


def test_a_view_shows_exactly_the_points_in_the_bent_picture() -> None:
    view = CameraView.of(WIDE, Mount(x_m=0.14, z_m=0.1), Pose(0.0, 0.0, 0.0))
    points = np.random.default_rng(5).uniform((0.3, -1.5, -0.5), (1.5, 1.5, 0.8), (300, 3))
    u, v = view.to_pixels(view.to_camera(points)).T
    is_inside = (u > -0.5) & (u < WIDE.width - 0.5) & (v > -0.5) & (v < WIDE.height - 0.5)
    shown = view.shows(points)
    assert not (shown & ~is_inside).any()
    assert (shown == is_inside).mean() > 0.97  # far aside, the polynomial bends points back into the picture
    assert not view.shows(-points).any()
