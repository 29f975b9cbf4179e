"""Measure how much two runs with the same commands differ: wheel speeds, path, ranges and pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.fidelity.commands import WheelCommand, integrate
from robotcore.fidelity.run_data import SIDES, AngleSeries, PictureSeries, RangeSeries, RunData

Array = NDArray[np.float64]

MIN_WINDOW_S, MAX_WINDOW_S = 0.1, 0.5
"""The shortest and the longest time over which a wheel's speed is measured, in seconds."""

WINDOW_COUNTS = 8
"""The number of encoder counts that are in a window at the mean speed, unless it is longer than `MAX_WINDOW_S`."""

MIN_RESPONSE = 0.1
"""The least response of a phase correlation whose shift counts, from 0 to 1."""

SHORTEST_M = 0.01
"""The shortest path, in metres, for which differences per metre are computed."""


@dataclass(frozen=True)
class WheelDifference:
    """The difference of the speeds of a wheel: simulated minus recorded. Speeds are means over a window."""

    rms_rad_s: float
    """The root mean square of the difference, in rad/s."""
    largest_rad_s: float
    """The largest absolute difference, in rad/s."""
    rms_share: float | None
    """The RMS of the difference divided by that of the commands; None if the wheel was not commanded to turn."""
    largest_share: float | None
    """The largest difference divided by the largest commanded speed; None if the wheel was not commanded to turn."""
    window_s: float
    """The time over which each speed is measured, in seconds."""


@dataclass(frozen=True)
class PathDifference:
    """The distances between two robots that drive at the same time."""

    recorded_m: float
    """The length of the recorded path in metres."""
    simulated_m: float
    """The length of the simulated path in metres."""
    end_m: float
    """The distance between the two robots at the end, in metres."""
    largest_m: float
    """The largest distance between the two robots, in metres."""
    mean_m: float
    """The mean distance between the two robots, in metres."""
    heading_rad: float
    """The heading of the simulated robot minus that of the recorded one at the end, in radians, with whole turns."""
    end_m_per_m: float | None
    """``end_m`` per metre of the recorded path; None for a robot that did not drive."""
    heading_rad_per_m: float | None
    """The absolute value of ``heading_rad`` per metre of the recorded path; None for a robot that did not drive."""
    known_s: float
    """The time of the last tick at which both poses are known, in seconds. The end of the path is there."""


@dataclass(frozen=True)
class RangeDifference:
    """The difference of the distances that a sensor measured in both runs."""

    median_m: float | None
    """The median of the absolute difference in metres; None if no sample has an echo in both runs."""
    p95_m: float | None
    """The 95th percentile of the absolute difference in metres."""
    pairs: int
    """The number of distances that both runs have."""
    recorded_lost_share: float | None
    """The share of lost echoes in the recorded run, from 0 to 1."""
    simulated_lost_share: float | None
    """The share of lost echoes in the simulated run, from 0 to 1."""


@dataclass(frozen=True)
class PictureDifference:
    """The difference of the pictures of a camera."""

    grey_share: float
    """The mean absolute difference of small grey pictures, divided by the range of grey levels."""
    shift_px: float | None
    """The median shift between two pictures by phase correlation, in pixels of the camera.

    None if most of the pictures have too few features in common.
    """
    pairs: int
    """The number of pictures that were compared."""


@dataclass(frozen=True)
class Differences:
    """The differences of a recorded run and a simulated run. A part that one of them lacks is empty."""

    path: PathDifference | None
    """The distances between the paths."""
    wheels: dict[str, WheelDifference] = field(default_factory=dict)
    """The differences of the wheels' speeds, by side."""
    ranges: dict[str, RangeDifference] = field(default_factory=dict)
    """The differences of the measured distances, by the name of the sensor."""
    pictures: dict[str, PictureDifference] = field(default_factory=dict)
    """The differences of the pictures, by the name of the camera."""


def compare(
    recorded: RunData, simulated: RunData, commands: Sequence[WheelCommand], step_rad: float = 0.0
) -> Differences:
    """Return the differences of two runs.

    commands: the recorded commands to the wheels.
    step_rad: the angle of one count of the encoders, in radians.
    """
    wheels = {}
    for index, side in enumerate(SIDES):
        if side in recorded.angles and side in simulated.angles:
            pair = recorded.angles[side], simulated.angles[side]
            if wheel := _compare_wheels(*pair, recorded.times, commands, index, step_rad):
                wheels[side] = wheel
    ranges = {
        name: _compare_ranges(series, simulated.ranges[name])
        for name, series in recorded.ranges.items()
        if name in simulated.ranges
    }
    pictures = {
        name: difference
        for name, series in recorded.pictures.items()
        if name in simulated.pictures and (difference := _compare_pictures(series, simulated.pictures[name]))
    }
    return Differences(_compare_paths(recorded, simulated), wheels, ranges, pictures)


def measure_speed(series: AngleSeries, times: Array, window: float) -> Array:
    """Return the mean speed over the window before each time, in rad/s. NaN at times without measurements."""
    ends, starts = (np.interp(at, series.times, series.angles) for at in (times, times - window))
    speeds = np.asarray((ends - starts) / window)
    is_measured = (times - window >= series.times[0] - 1e-9) & (times <= series.times[-1] + 1e-9)
    return np.where(is_measured, speeds, np.nan)


def find_window(commands: Sequence[WheelCommand], times: Array, step_rad: float) -> float:
    """Return the time over which speeds are measured, in seconds. Encoders with few counts need a longer one."""
    turned = np.abs(np.diff(integrate(commands, times), axis=0)).sum() / 2
    speed = turned / (times[-1] - times[0]) if times[-1] > times[0] else 0.0
    wanted = WINDOW_COUNTS * step_rad / speed if speed else MAX_WINDOW_S
    return float(min(max(wanted, MIN_WINDOW_S), MAX_WINDOW_S))


def _compare_wheels(
    recorded: AngleSeries,
    simulated: AngleSeries,
    times: Array,
    commands: Sequence[WheelCommand],
    side: int,
    step_rad: float,
) -> WheelDifference | None:
    window = find_window(commands, times, step_rad)
    difference = measure_speed(simulated, times, window) - measure_speed(recorded, times, window)
    is_known = np.isfinite(difference)
    if not is_known.any():
        return None
    difference = difference[is_known]
    commanded = (integrate(commands, times)[:, side] - integrate(commands, times - window)[:, side])[is_known] / window
    rms, largest = _compute_rms(difference), float(np.abs(difference).max())
    wanted, fastest = _compute_rms(commanded), float(np.abs(commanded).max())
    return WheelDifference(
        rms, largest, rms / wanted if wanted else None, largest / fastest if fastest else None, window
    )


def _compute_rms(values: Array) -> float:
    return math.sqrt(float(np.mean(np.square(values))))


def _compare_paths(recorded: RunData, simulated: RunData) -> PathDifference | None:
    is_known = ~np.isnan(recorded.poses[:, 0]) & ~np.isnan(simulated.poses[:, 0])
    if not is_known.any():
        return None
    first, second = recorded.poses[is_known], simulated.poses[is_known]
    distances, driven = measure_distances(recorded, simulated)[is_known], recorded.length_m
    turn = (second[-1, 2] - second[0, 2]) - (first[-1, 2] - first[0, 2])
    end, has_driven = float(distances[-1]), driven >= SHORTEST_M
    return PathDifference(
        recorded_m=driven,
        simulated_m=simulated.length_m,
        end_m=end,
        largest_m=float(distances.max()),
        mean_m=float(distances.mean()),
        heading_rad=float(turn),
        end_m_per_m=end / driven if has_driven else None,
        heading_rad_per_m=abs(float(turn)) / driven if has_driven else None,
        known_s=float(recorded.times[is_known][-1]),
    )


def measure_distances(recorded: RunData, simulated: RunData) -> Array:
    """Return the distance between the two robots at each tick, in metres, of shape (n,). NaN if one is unknown."""
    return np.asarray(np.hypot(*(simulated.poses[:, :2] - recorded.poses[:, :2]).T))


def _compare_ranges(recorded: RangeSeries, simulated: RangeSeries) -> RangeDifference:
    ticks = [tick for tick in recorded.distances if tick in simulated.distances]
    pairs = [(recorded.distances[tick], simulated.distances[tick]) for tick in ticks]
    found = [np.stack(pair) for pair in pairs if pair[0].shape == pair[1].shape]
    both = np.concatenate(found, axis=1) if found else np.empty((2, 0))
    differences = np.abs(np.diff(both[:, np.isfinite(both).all(axis=0)], axis=0))[0]
    return RangeDifference(
        median_m=float(np.median(differences)) if len(differences) else None,
        p95_m=float(np.percentile(differences, 95)) if len(differences) else None,
        pairs=len(differences),
        recorded_lost_share=recorded.lost_share,
        simulated_lost_share=simulated.lost_share,
    )


def _compare_pictures(recorded: PictureSeries, simulated: PictureSeries) -> PictureDifference | None:
    ticks = [tick for tick in recorded.pictures if tick in simulated.pictures]
    pairs = [(recorded.pictures[tick], simulated.pictures[tick]) for tick in ticks]
    pairs = [(first, second) for first, second in pairs if first.shape == second.shape]
    if not pairs:
        return None
    grey = float(np.mean([np.abs(first - second).mean() for first, second in pairs])) / 255
    scale = recorded.width_px / pairs[0][0].shape[1]
    shifts = [_measure_shift(first, second) for first, second in pairs]
    found = [shift * scale for shift in shifts if shift is not None]
    return PictureDifference(grey, float(np.median(found)) if 2 * len(found) >= len(pairs) else None, len(pairs))


def _measure_shift(first: Array, second: Array) -> float | None:
    """Return the shift between two pictures in their pixels; None if they have too few features in common."""
    if not (first.std() and second.std()):
        return None
    window = cv2.createHanningWindow(first.shape[::-1], cv2.CV_64F)
    (x, y), response = cv2.phaseCorrelate(first.copy(), second.copy(), window)  # OpenCV 5 changes its arguments
    return math.hypot(x, y) if response >= MIN_RESPONSE else None
