"""Fits the intrinsics and the distortion of a camera to views of a chessboard."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.calibration.camera.board import Board, Corners, ViewSelection
from robotcore.calibration.least_squares import round_measured
from robotcore.canvas import SERIES
from robotcore.errors import CalibrationError
from robotcore.kinds.camera import CameraDescription
from robotcore.lens import is_invertible
from robotcore.optics import Image, Intrinsics
from robotcore.text import pluralize
from robotcore.view.chart import Chart, Series

MIN_VIEWS = 8
"""The least number of views for a fit."""

MAX_ERROR_SHARE = 1 / 640
"""The greatest root mean square of the corners' errors, as a share of the picture's width: 1 pixel of 640."""

MAX_FOCAL_ERROR = 0.005
"""The greatest standard deviation of the focal length, as a share of it."""

MIN_REACH = 0.6
"""The corners must reach this share of the way from the middle to a corner of the picture. Beyond, the distortion is a
guess."""

OUTLIER_FACTOR, MAX_OUTLIERS = 3.0, 0.2
"""A view is left out if its error is this many times the median. At most this share of the views is left out."""

MIN_GAIN = 12.0
"""The coefficient k3 is fitted if it lowers the sum of the squared errors by this many variances of a corner.

This is a likelihood-ratio test with a threshold of 3.5 standard deviations. In the views of most lenses, k2 and k3 are
nearly interchangeable, so that k3 would only fit the noise.
"""

PARAMETERS = ("focal length", "column of the centre", "row of the centre", "k1", "k2", "p1", "p2", "k3")


@dataclass(frozen=True)
class IntrinsicsFit:
    """The intrinsics of a camera with square pixels, and how well they fit the views."""

    size: tuple[int, int]
    """The width and the height of the pictures, in pixels."""
    focal_length_px: float
    centre_px: tuple[float, float]
    """The column and the row of the optical axis, in pixels."""
    distortion: tuple[float, float, float, float, float]
    """OpenCV's k1, k2, p1, p2 and k3."""
    deviations: tuple[float, ...]
    """The standard deviations of `PARAMETERS`, in the same order and units."""
    error_px: float
    """The root mean square of the distances between found and computed corners, in pixels."""
    views: int
    """The number of views in the fit."""
    left_out: int
    """The number of views that fitted badly and were left out."""
    uncovered: tuple[str, ...]
    """The regions of the picture that no corner has reached."""

    @property
    def horizontal_fov_rad(self) -> float:
        """The horizontal field of view that follows from the focal length, in radians."""
        return 2 * math.atan(self.size[0] / 2 / self.focal_length_px)

    @property
    def fov_deviation_rad(self) -> float:
        """The standard deviation of the field of view, in radians."""
        half = self.size[0] / 2
        return 2 * half / (self.focal_length_px**2 + half**2) * self.deviations[0]


def collect_views(pictures: Iterable[Image], board: Board) -> tuple[ViewSelection, list[Image]]:
    """Return the views of a board in grey pictures of one size, and the first pictures without the board.

    Raises CalibrationError without pictures, or if their sizes differ.
    """
    selection: ViewSelection | None = None
    without: list[Image] = []
    size = (0, 0)
    for picture in pictures:
        if selection is None:
            size = picture.shape[1], picture.shape[0]
            selection = ViewSelection(size)
        elif size != picture.shape[1::-1]:
            text = f"the pictures have different sizes: {size[0]}x{size[1]} and {picture.shape[1]}x{picture.shape[0]}"
            raise CalibrationError(f"{text}. Take all pictures with one camera and one size", kind="different-sizes")
        corners = board.find(picture)
        if corners is not None:
            selection.add(corners)
        elif len(without) < MIN_VIEWS:
            without.append(picture)
    if selection is None:
        raise CalibrationError("there are no pictures. Take pictures of the chessboard", kind="no-pictures")
    return selection, without


def require_board(selection: ViewSelection, board: Board, without: Sequence[Image]) -> None:
    """Raise CalibrationError if hardly any picture shows the board. The error names a board of another size in them.

    without: some pictures without the board.
    """
    if len(selection.views) >= MIN_VIEWS:
        return
    if other := board.find_other_size(without):
        raise CalibrationError(
            f"the pictures show no board of {board} inner corners, but one of {other}. Give --board {other}, "
            "or keep the whole board in the picture",
            kind="other-board",
            board=str(other),
        )
    if selection.views:
        return
    raise CalibrationError(
        f"no picture shows a whole chessboard of {board} inner corners, at which four squares meet. Keep the whole "
        "board with a white margin in the picture, give it more light, and count its inner corners, not its squares",
        kind="no-board",
        board=str(board),
    )


def fit_intrinsics(selection: ViewSelection, board: Board) -> IntrinsicsFit:
    """Return the intrinsics that fit the views best.

    Raises CalibrationError if the views are too few or too similar, or do not fit.
    """
    views = selection.views
    if len(views) < MIN_VIEWS:
        raise CalibrationError(
            f"only {pluralize(len(views), 'picture')} with different positions of the board, and a fit needs "
            f"{MIN_VIEWS}. Move and tilt the board more between the pictures",
            kind="too-few-views",
            views=len(views),
        )
    raw = _fit(views, board, selection.size)
    limit = OUTLIER_FACTOR * float(np.median(raw.view_errors))
    kept = [view for view, error in zip(views, raw.view_errors, strict=True) if error <= limit]
    if MIN_VIEWS <= len(kept) < len(views) and len(views) - len(kept) <= MAX_OUTLIERS * len(views):
        raw = _fit(kept, board, selection.size)
    else:
        kept = views
    fit = IntrinsicsFit(
        selection.size,
        raw.focal_length,
        raw.centre,
        raw.distortion,
        raw.deviations,
        raw.error,
        len(kept),
        len(views) - len(kept),
        tuple(selection.uncovered),
    )
    _require_quality(fit, kept)
    return fit


def _require_quality(fit: IntrinsicsFit, views: Sequence[Corners]) -> None:
    width, height = fit.size
    if fit.error_px > MAX_ERROR_SHARE * width:
        raise CalibrationError(
            f"the corners differ from the fit by {fit.error_px:.2f} px, and the limit is "
            f"{MAX_ERROR_SHARE * width:.2f} px. The board must be flat, and must stand still in each picture",
            kind="bad-fit",
            error_px=fit.error_px,
        )
    if (share := fit.deviations[0] / fit.focal_length_px) > MAX_FOCAL_ERROR:
        raise CalibrationError(
            f"the focal length is uncertain by {share:.1%}, and the limit is {MAX_FOCAL_ERROR:.1%}. Tilt the board "
            "more, by about 30° to each side, and bring it near",
            kind="uncertain-focal-length",
            share=share,
        )
    middle = np.array(((width - 1) / 2, (height - 1) / 2))
    reach = max(float(np.linalg.norm(view - middle, axis=1).max()) for view in views) / float(np.linalg.norm(middle))
    if reach < MIN_REACH:
        raise CalibrationError(
            f"the board reached only {reach:.0%} of the way to the corners of the picture, and a fit of the distortion "
            f"needs {MIN_REACH:.0%}. Hold the board in each corner of the picture",
            kind="corners-not-covered",
            reach=reach,
        )
    u, v = fit.centre_px
    if not (0.25 * width < u < 0.75 * width and 0.25 * height < v < 0.75 * height):
        raise CalibrationError(
            f"by the fit, the optical axis is at column {u:.0f} and row {v:.0f}, far from the middle of a picture of "
            f"{width}x{height}. Take more pictures with the board tilted to all sides",
            kind="centre-outside",
            centre_px=(u, v),
        )


@dataclass(frozen=True)
class _RawFit:
    focal_length: float
    centre: tuple[float, float]
    distortion: tuple[float, float, float, float, float]
    deviations: tuple[float, ...]
    error: float
    view_errors: NDArray[np.float64]


def _fit(views: Sequence[Corners], board: Board, size: tuple[int, int]) -> _RawFit:
    simple = _calibrate(views, board, size, cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_FIX_K3)
    full = _calibrate(views, board, size, cv2.CALIB_FIX_ASPECT_RATIO)
    corners = sum(len(view) for view in views)
    gain = 2 * corners * (simple.error**2 - full.error**2) / max(full.error**2, 1e-12)
    return full if gain > MIN_GAIN else simple


def _calibrate(views: Sequence[Corners], board: Board, size: tuple[int, int], flags: int) -> _RawFit:
    width, height = size
    start = np.array(((width, 0.0, (width - 1) / 2), (0.0, width, (height - 1) / 2), (0.0, 0.0, 1.0)))
    try:
        error, matrix, distortion, _, _, deviations, _, view_errors = cv2.calibrateCameraExtended(
            [board.points] * len(views), list(views), size, start, np.zeros(5), flags=flags
        )
    except cv2.error as failure:
        text = "OpenCV finds no camera that fits the pictures. Take them again, with the board tilted to all sides"
        raise CalibrationError(text, kind="no-fit") from failure
    k1, k2, p1, p2, k3 = (float(each) for each in np.ravel(distortion)[:5])
    spread = np.ravel(deviations)
    return _RawFit(
        float(matrix[1, 1]),
        (float(matrix[0, 2]), float(matrix[1, 2])),
        (k1, k2, p1, p2, k3),
        tuple(float(each) for each in spread[1:9]),
        float(error),
        np.ravel(view_errors),
    )


def build_description_values(fit: IntrinsicsFit, camera: CameraDescription) -> dict[str, Any]:
    """Return the keys of a camera's table for a fit, with as many digits as the fit allows.

    Raises CalibrationError if the pictures have another aspect ratio than the camera, or if the distortion cannot be
    inverted in the whole picture.
    """
    (width, height), scale = fit.size, camera.width_px / fit.size[0]
    if abs(height * scale - camera.height_px) > 1:
        raise CalibrationError(
            f"the pictures have {width}x{height} px, and the description of {camera.name} has "
            f"{camera.width_px}x{camera.height_px} px: another aspect ratio, so another field of view. Take pictures "
            "of this camera with the size of the description",
            kind="other-aspect-ratio",
            device=camera.name,
        )
    centre = tuple((each + 0.5) * scale - 0.5 for each in fit.centre_px)
    spreads = [each * scale for each in fit.deviations[1:3]]
    fov = round_measured(fit.horizontal_fov_rad, fit.fov_deviation_rad)
    column, row = (round_measured(*pair) for pair in zip(centre, spreads, strict=True))
    pairs = zip(fit.distortion, fit.deviations[3:], strict=True)
    distortion = [round_measured(*pair) if pair[1] else 0.0 for pair in pairs]
    distorted = Intrinsics(camera.width_px, camera.height_px, fov, (column, row), tuple(distortion))
    if not is_invertible(distorted):
        raise CalibrationError(
            "by the fit, the lens shows a direction twice. The distortion is wrong where no board was. Hold the board "
            "in each corner of the picture",
            kind="distortion-not-invertible",
        )
    return {"horizontal_fov_rad": fov, "centre_px": [column, row], "distortion": distortion}


def build_views_chart(selection: ViewSelection, camera: str) -> Chart:
    """Return a chart of the corners in all views, in the picture of a camera."""
    width, height = selection.size
    right, upper = width - 1.0, height - 1.0
    columns, rows = np.vstack(list(selection.views)).T
    series = [
        Series(columns, upper - rows, label="corners of the board", has_dots=True),
        Series([0.0, right, right, 0.0, 0.0], [0.0, 0.0, upper, upper, 0.0], SERIES[1], label="edge of the picture"),
    ]
    return Chart(f"Views of the board by {camera}", series, "columns", "rows")
