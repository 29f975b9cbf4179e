"""Intrinsics from pictures of a chessboard: their errors, and the pictures that are refused."""

from __future__ import annotations

import random
from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np
import pytest

from robotcore.calibration.camera.board import Board, ViewSelection
from robotcore.calibration.camera.intrinsics import (
    IntrinsicsFit,
    build_description_values,
    collect_views,
    fit_intrinsics,
    require_board,
)
from robotcore.description import load_robot
from robotcore.errors import CalibrationError, UsageError
from robotcore.kinds.camera import CameraDescription
from robotcore.optics import Image
from tests.robotcore.calibration.camera.rendered_boards import build_camera
from tests.texts import Raises

BOARD = Board(9, 6, 0.025)
CAMERA = build_camera((320, 240), 290.0, (164.0, 117.0), (-0.2, 0.03, 0.001, -0.001, 0.0), noise=3.0)
EYE = load_robot("rover").all_of(CameraDescription)[0]


@cache
def take_pictures(count: int = 16, seed: int = 1) -> Sequence[Image]:
    return tuple(CAMERA.render_views(BOARD, count, random.Random(seed)))


def fit(pictures: Sequence[Image]) -> IntrinsicsFit:
    return fit_intrinsics(collect_views(pictures, BOARD)[0], BOARD)


@pytest.mark.slow
def test_known_intrinsics_are_recovered_within_their_uncertainty() -> None:
    found = fit(take_pictures())
    assert found.horizontal_fov_rad == pytest.approx(CAMERA.intrinsics.horizontal_fov, rel=0.002)
    assert found.centre_px == pytest.approx(CAMERA.intrinsics.centre, abs=0.5)
    assert found.distortion[:2] == pytest.approx(CAMERA.intrinsics.distortion[:2], abs=0.03)
    assert abs(found.focal_length_px - CAMERA.intrinsics.focal_length) < 5 * found.deviations[0]
    assert found.error_px < 0.2
    assert found.left_out == 0


@pytest.mark.slow
def test_the_values_describe_a_camera_that_can_be_simulated() -> None:
    values = build_description_values(fit(take_pictures()), EYE)
    described = CameraDescription.model_validate({**EYE.model_dump(exclude_none=True), **values})
    assert described.intrinsics.focal_length == pytest.approx(CAMERA.intrinsics.focal_length, rel=0.002)
    assert described.intrinsics.cx == pytest.approx(CAMERA.intrinsics.cx, abs=0.5)


@pytest.mark.slow
def test_pictures_of_another_size_give_values_for_the_size_of_the_description() -> None:
    wide = EYE.model_copy(update={"width_px": 640, "height_px": 480})
    values = build_description_values(fit(take_pictures()), wide)
    assert values["horizontal_fov_rad"] == pytest.approx(CAMERA.intrinsics.horizontal_fov, rel=0.002)
    assert values["centre_px"] == pytest.approx([2 * 164.5 - 0.5, 2 * 117.5 - 0.5], abs=1.0)


@pytest.mark.slow
def test_pictures_of_another_aspect_ratio_are_refused(raises: Raises) -> None:
    tall = EYE.model_copy(update={"height_px": 180})
    with raises(CalibrationError, "other-aspect-ratio", device="eye"):
        build_description_values(fit(take_pictures()), tall)


@pytest.mark.slow
def test_a_view_that_does_not_fit_is_left_out() -> None:
    selection, _ = collect_views(take_pictures(), BOARD)
    bent = selection.views[3].copy()
    bent[:20] += 4.0
    selection.views[3] = bent
    found = fit_intrinsics(selection, BOARD)
    assert found.left_out == 1
    assert found.focal_length_px == pytest.approx(CAMERA.intrinsics.focal_length, rel=0.003)


@pytest.mark.slow
def test_a_board_that_is_not_flat_is_refused(raises: Raises) -> None:
    selection, _ = collect_views(take_pictures(), BOARD)
    noise = np.random.default_rng(2)
    selection.views = [view + noise.normal(0, 2, view.shape).astype(np.float32) for view in selection.views]
    with raises(CalibrationError, "bad-fit", hide=["1.93"]):
        fit_intrinsics(selection, BOARD)


@pytest.mark.slow
def test_few_pictures_are_refused(raises: Raises) -> None:
    with raises(CalibrationError, "too-few-views", hide=["2 pictures", "3 pictures", "1 picture"]):
        fit(take_pictures(3))


@pytest.mark.slow
def test_a_board_of_another_size_is_named(raises: Raises) -> None:
    other = Board(8, 6, 0.025)
    tilts = (np.array((0.1 * number, 0.2, 0.0)) for number in range(2))
    pictures = [CAMERA.render(other, tilt, np.array((-0.09, -0.06, 0.35)), random.Random(1)) for tilt in tilts]
    selection, without = collect_views(pictures, BOARD)
    with raises(CalibrationError, "other-board", board="8x6"):
        require_board(selection, BOARD, without)


def test_pictures_without_a_board_are_refused(raises: Raises) -> None:
    grey = np.full((120, 160), 128, np.uint8)
    with raises(CalibrationError, "no-board", board="9x6"):
        require_board(*_swap(collect_views([grey, grey], BOARD)))


def _swap(found: tuple[ViewSelection, list[Image]]) -> tuple[ViewSelection, Board, list[Image]]:
    return found[0], BOARD, found[1]


def test_pictures_of_two_sizes_are_refused(raises: Raises) -> None:
    with raises(CalibrationError, "different-sizes"):
        collect_views([np.zeros((120, 160), np.uint8), np.zeros((240, 320), np.uint8)], BOARD)


def test_no_pictures_are_refused(raises: Raises) -> None:
    with raises(CalibrationError, "no-pictures"):
        collect_views([], BOARD)


@pytest.mark.parametrize("size", ["9", "9x2", "31x6", "axb", "-9x6"])
def test_a_text_that_is_no_size_of_a_board_is_refused(size: str, raises: Raises) -> None:
    with raises(UsageError, "wrong-board"):
        Board.parse(size, 0.025)


def test_a_square_in_millimetres_is_refused(raises: Raises) -> None:
    with raises(UsageError, "wrong-square", square_m=25.0):
        Board.parse("9x6", 25.0)


def test_views_in_the_same_place_count_once_and_missing_regions_are_named() -> None:
    selection = ViewSelection((300, 300))
    corners = np.array([[10.0, 10.0], [90.0, 10.0], [10.0, 90.0]], np.float32)
    assert selection.add(corners)
    assert not selection.add(corners + 2)
    assert selection.add(corners + 100)
    assert "top left" not in selection.uncovered
    assert "centre" not in selection.uncovered
    assert "bottom right" in selection.uncovered


def test_a_live_view_counts_only_if_the_board_stands_still() -> None:
    selection = ViewSelection((300, 300))
    corners = np.array([[10.0, 10.0], [90.0, 10.0]], np.float32)
    assert not selection.add_still(corners)
    assert not selection.add_still(corners + 5)
    assert selection.add_still(corners + 5.5)
    assert not selection.add_still(None)


@pytest.mark.slow
def test_a_refined_corner_is_exact_to_a_tenth_of_a_pixel() -> None:
    camera = build_camera((320, 240), 300.0, (159.5, 119.5))
    position = np.array([-0.1, -0.06, 0.4])
    picture = camera.render(BOARD, np.zeros(3), position, random.Random(0))
    corners = BOARD.find(picture)
    assert corners is not None
    true, _ = cv2.projectPoints(
        BOARD.points, np.zeros(3), position, np.array([[300.0, 0, 159.5], [0, 300.0, 119.5], [0, 0, 1]]), np.zeros(5)
    )
    true = np.asarray(true).reshape(-1, 2)
    error = min(np.abs(order - true).max() for order in (corners, corners[::-1]))
    assert error < 0.1
