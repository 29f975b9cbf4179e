"""Measures the delay of a camera: compares the rotation in the pictures of a turning robot with that of a sensor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from robotcore.canvas import RULE, SERIES
from robotcore.errors import CalibrationError
from robotcore.kinds.camera import Frame
from robotcore.optics import Image, Intrinsics
from robotcore.view.chart import Chart, Series

Array = NDArray[np.float64]

MAX_WIDTH_PX = 640
"""The width to which larger pictures are reduced, in pixels."""

BASELINE_S = 0.08
"""The time between two pictures whose rotation is measured, in seconds."""

ROUNDING_S = 1e-6

SMOOTHING_S = 0.05
"""The standard deviation of the filter that smooths the sensor's headings, in seconds.

Without it, the steps of an encoder would favour delays of half a tick, at which the interpolation smooths them.
"""

MAX_POINTS, MIN_POINTS = 150, 6
"""The greatest number of points that are tracked from picture to picture, and the least that give a rotation."""

MIN_DISTANCE_PX, BLOCK_PX, QUALITY = 6, 7, 0.01
"""The parameters of OpenCV's `goodFeaturesToTrack`."""

MAX_RETURN_PX = 0.5
"""A point that is tracked forth and back must return to within this distance, in pixels."""

MIN_PICTURES = 20
"""The least number of pictures with a rotation."""

MIN_TURN_RAD = 0.3
"""The least sum of all rotations between pictures, in radians, from which a delay is measured."""

MIN_FIT = 0.8
"""The least share of the pictures' rotation that the sensor's rotation must explain."""

DEGREE = 5
"""The degree of the polynomial that relates the headings in the pictures to those of the sensor."""

ROBUST_PASSES, HUBER = 3, 1.345
"""The number of fits. After each, a turn with an error above this many standard deviations gets a lower weight (Huber).

Some turns are wrong, because the tracked points are on the edge of a near body, which moves on.
"""

MAX_DELAY_S, MIN_DELAY_S, STEP_S = 0.6, -0.1, 0.002
"""The delays that are tried, and their distance, in seconds. A negative delay shows that the sensor itself is late."""

MAX_DEVIATION_S = 0.01
"""The greatest standard deviation of a delay, in seconds."""


class TimedPicture(NamedTuple):
    """A picture of a turning robot."""

    grey: Image
    stamp: float
    """The time of capture by the camera's driver, in seconds."""


class Heading(NamedTuple):
    """A heading of the robot that a sensor has measured."""

    time: float
    """The time of the measurement, in seconds."""
    angle: float
    """The angle in radians, which counts whole turns."""


@dataclass(frozen=True)
class DelayFit:
    """The delay of a camera, and how well the rotation in the pictures fits that of the sensor."""

    latency_s: float
    """The time from the capture of a picture until it is available, in seconds."""
    deviation_s: float
    """The standard deviation of ``latency_s``, in seconds."""
    stamp_error_s: float
    """The time from the capture of a picture to its time stamp, in seconds; 0 if the stamps are right."""
    scale: float
    """The rotation in the pictures, divided by that of the sensor. It differs from 1 if near things move past."""
    share: float
    """The share of the pictures' rotation that the sensor's rotation explains, from 0 to 1."""
    pictures: int
    """The number of pictures in the fit."""
    shifts_s: tuple[float, ...]
    """The delays that were tried, in seconds, for a plot."""
    errors_rad: tuple[float, ...]
    """The root mean square of the rotation's error at each of ``shifts_s``, in radians."""


class TurnRecord:
    """Collects the pictures and the headings of a turning robot. It stores few pictures, and all of their times."""

    def __init__(self) -> None:
        self.pictures: list[TimedPicture] = []
        self.headings: list[Heading] = []
        self.stamps: list[float] = []
        """The time stamp of each picture, in seconds."""
        self.ages: list[float] = []
        """The age of each picture by its stamp when it was read, in seconds."""
        self._last = -1

    def add_frame(self, frame: Frame, now: float) -> None:
        """Add the newest picture at a time in seconds. A picture that was added before is ignored."""
        if frame.sequence == self._last:
            return
        self._last = frame.sequence
        self.stamps.append(frame.time)
        self.ages.append(now - frame.time)
        if not self.pictures or frame.time - self.pictures[-1].stamp >= BASELINE_S - ROUNDING_S:
            self.pictures.append(TimedPicture(shrink(frame.grey), frame.time))

    def add_heading(self, heading: Heading) -> None:
        """Add the newest heading. One that was added before is ignored."""
        if not self.headings or heading.time > self.headings[-1].time:
            self.headings.append(heading)


def shrink(picture: Image) -> Image:
    """Return a picture of at most `MAX_WIDTH_PX` pixels in a row."""
    height, width = picture.shape[:2]
    if width <= MAX_WIDTH_PX:
        return picture
    size = (MAX_WIDTH_PX, max(1, round(height * MAX_WIDTH_PX / width)))
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def _measure_turns(pictures: Sequence[TimedPicture], horizontal_fov: float) -> Iterator[tuple[float, float, float]]:
    """Yield the stamps of each two pictures in seconds, and the turn between them in radians, positive to the left."""
    for first, second in pairwise(pictures):
        height, width = first.grey.shape[:2]
        turn = _measure_turn(first.grey, second.grey, Intrinsics(width, height, horizontal_fov))
        if turn is not None:
            yield first.stamp, second.stamp, turn


def _measure_turn(first: Image, second: Image, intrinsics: Intrinsics) -> float | None:
    points = cv2.goodFeaturesToTrack(first, MAX_POINTS, QUALITY, MIN_DISTANCE_PX, blockSize=BLOCK_PX)
    if points is None or len(points) < MIN_POINTS:
        return None
    moved, is_found, _ = cv2.calcOpticalFlowPyrLK(first, second, points, points.copy())
    back, is_back, _ = cv2.calcOpticalFlowPyrLK(second, first, moved, points.copy())
    is_good = np.ravel(is_found).astype(bool) & np.ravel(is_back).astype(bool)
    is_good &= np.linalg.norm((back - points).reshape(-1, 2), axis=1) < MAX_RETURN_PX
    if is_good.sum() < MIN_POINTS:
        return None
    before, after = points.reshape(-1, 2)[is_good, 0], moved.reshape(-1, 2)[is_good, 0]
    bearings = [np.arctan2(intrinsics.cx - u, intrinsics.focal_length) for u in (before, after)]
    return float(np.median(bearings[0] - bearings[1]))


def fit_delay(record: TurnRecord, horizontal_fov_rad: float, tick_s: float) -> DelayFit:
    """Return the delay at which the rotation in the pictures fits the headings best.

    horizontal_fov_rad: the camera's field of view. An error of it does not change the delay.
    tick_s: the time between two reads of the camera, in seconds.

    Raises CalibrationError if the pictures show too little rotation, or another one than the sensor.
    """
    pairs = [*_measure_turns(record.pictures, horizontal_fov_rad)]
    if len(pairs) < MIN_PICTURES:
        raise CalibrationError(
            f"only {len(pairs)} pictures show enough details to measure a rotation, and {MIN_PICTURES} are needed. Let "
            "the camera see a room with furniture or pictures, and give it light",
            kind="too-few-details",
            pictures=len(pairs),
        )
    starts, ends, turned = (np.array(column) for column in zip(*pairs, strict=True))
    times, angles = _smooth(record.headings)
    if np.abs(np.diff(angles)).sum() < MIN_TURN_RAD:
        raise CalibrationError(
            "by its sensor, the robot did not turn. Check that the wheels can turn, and test the devices: robotcore "
            "test-devices",
            kind="no-turn",
        )
    shifts = np.arange(MIN_DELAY_S, MAX_DELAY_S, STEP_S)
    weights = np.ones(len(turned))
    for _ in range(ROBUST_PASSES):
        fits = [_fit_scale(starts - shift, ends - shift, turned, weights, times, angles) for shift in shifts]
        errors = np.array([float(weights @ difference**2) for _, difference in fits])
        best = int(errors.argmin())
        scale, difference = fits[best]
        spread = 1.4826 * float(np.median(np.abs(difference)))
        weights = 1 / np.maximum(1.0, np.abs(difference) / max(HUBER * spread, 1e-9))
    share = 1 - errors[best] / float(weights @ turned**2)
    if share < MIN_FIT or scale <= 0:
        mirrored = " The picture seems to be mirrored." if scale < 0 and share >= MIN_FIT else ""
        raise CalibrationError(
            f"the rotation in the pictures fits that of the sensor only to {max(share, 0.0):.0%}.{mirrored} Nothing "
            "else may move in the picture. Test the devices: robotcore test-devices",
            kind="other-rotation",
            share=share,
        )
    if not 0 < best < len(shifts) - 1:
        raise CalibrationError(
            f"the delay is outside of {MIN_DELAY_S:g} s to {MAX_DELAY_S:g} s. Check the time stamps of the driver",
            kind="delay-out-of-range",
        )
    below, middle, above = errors[best - 1 : best + 2]
    curvature = (above - 2 * middle + below) / STEP_S**2
    stamp_error = float(shifts[best] + (below - above) / (2 * curvature * STEP_S))
    deviation = math.sqrt(2 * middle / max(len(pairs) - 2, 1) / curvature)
    if deviation > MAX_DEVIATION_S:
        raise CalibrationError(
            f"the delay is uncertain by {deviation:.3f} s, and the limit is {MAX_DEVIATION_S:g} s. Give the camera "
            "more light and details",
            kind="uncertain-delay",
            deviation_s=deviation,
        )
    return DelayFit(
        stamp_error + _find_age(record, tick_s),
        deviation,
        stamp_error,
        scale,
        share,
        len(pairs),
        tuple(shifts.tolist()),
        tuple(np.sqrt(errors / len(pairs)).tolist()),
    )


def _smooth(headings: Sequence[Heading]) -> tuple[Array, Array]:
    """Return times at equal distances, and the smoothed heading at each, by local straight lines."""
    measured_at, measured = (np.array(column) for column in zip(*headings, strict=True))
    times = np.arange(measured_at[0], measured_at[-1], STEP_S)
    lags = measured_at - times[:, None]
    weights = np.exp(-((lags / SMOOTHING_S) ** 2) / 2)
    total, first, second = weights.sum(1), (weights * lags).sum(1), (weights * lags**2).sum(1)
    level, slope = weights @ measured, (weights * lags) @ measured
    determinant = total * second - first**2
    return times, (second * level - first * slope) / determinant


def _fit_scale(
    starts: Array, ends: Array, turned: Array, weights: Array, times: Array, angles: Array
) -> tuple[float, Array]:
    """Return the mean scale of the sensor's rotation that fits best, and the error of each turn in radians.

    A robot that turns on the spot has the same view whenever it has the same heading. So the rotation in the pictures
    is a function of the heading, with a slope that depends on the distance of the things in view: a polynomial.
    """
    middle, half = (angles.max() + angles.min()) / 2, np.ptp(angles) / 2
    powers = [
        legendre.legvander((np.interp(when, times, angles) - middle) / half, DEGREE)[:, 1:] for when in (ends, starts)
    ]
    steps = powers[0] - powers[1]
    roots = np.sqrt(weights)
    factors = np.linalg.lstsq(steps * roots[:, None], turned * roots, rcond=None)[0]
    difference = turned - steps @ factors
    whole_turn = 2 * half
    ways = legendre.legval(np.array((1.0, -1.0)), np.array((0.0, *factors)))
    return float(ways[0] - ways[1]) / whole_turn, difference


def _find_age(record: TurnRecord, tick_s: float) -> float:
    """Return the age of a picture by its stamp when it becomes available, in seconds.

    A picture is read at the first tick after it has become available. So the least age is nearest to it, unless the
    camera and the ticks run in step: then the wait is unknown, and on average half a tick.
    """
    is_slower = float(np.median(np.diff(record.stamps))) > 1.5 * tick_s
    is_in_step = is_slower and float(np.ptp(np.percentile(record.ages, (5, 95)))) < tick_s / 10
    return float(np.percentile(record.ages, 5)) - (tick_s / 2 if is_in_step else 0.0)


def list_turn_rates(ticks: int, tick_s: float, limit_rad_s: float) -> Iterator[float]:
    """Yield the turn rate of each tick, in rad/s. The robot turns to and fro, and ends about where it began.

    Two frequencies without a common divisor leave no doubt about the shift.
    """
    duration = ticks * tick_s
    for tick in range(ticks):
        time = tick * tick_s
        envelope = min(1.0, 4 * time / duration, 4 * (1 - time / duration))
        wave = 0.6 * math.sin(math.tau * 0.5 * time) + 0.4 * math.sin(math.tau * 0.83 * time)
        yield limit_rad_s * envelope * wave


def build_delay_chart(fit: DelayFit, camera: str) -> Chart:
    """Return a chart of the error at each delay that was tried, with the best delay and that of the time stamps."""
    errors = np.degrees(fit.errors_rad)
    by_stamps = fit.latency_s - fit.stamp_error_s
    height = [0.0, float(errors.max())]
    series = [
        Series([by_stamps + shift for shift in fit.shifts_s], errors, label="error of the rotation"),
        Series([fit.latency_s] * 2, height, SERIES[1], label="best delay"),
        Series([by_stamps] * 2, height, RULE, label="delay by the time stamps"),
    ]
    return Chart(f"Delay of {camera}", series, "delay from the capture in s", "degrees")
