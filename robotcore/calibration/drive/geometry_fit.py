"""Fits the wheel radius and the track to the angles of the wheels and to the motion of the robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotcore.calibration.least_squares import Estimate, fit_linear
from robotcore.errors import CalibrationError

MIN_WHEEL_RAD = 3.0
"""The least angle by which the wheels must turn in a drive, in radians."""

MAX_CHANGE = 2.0
"""The greatest factor between a measured length and that of the file. A larger one is an error of the measurement."""

ALIGNMENT_RAD = math.radians(1.0)
"""The standard deviation of the direction in which a person puts the robot, in radians."""


@dataclass(frozen=True)
class StraightDrive:
    """A straight drive, and the angles of the wheels."""

    left_rad: float
    """The angle by which the left wheels have turned, in radians."""
    right_rad: float
    """The angle by which the right wheels have turned, in radians."""
    way_m: float
    """The measured way of the middle of the axle, in metres, negative backward."""
    deviation_m: float
    """The standard deviation of the way, in metres."""
    turn_rad: float | None = None
    """The angle by which the robot has turned, in radians; None if it was not measured."""

    @property
    def mean_rad(self) -> float:
        """The mean angle of the wheels, in radians."""
        return (self.left_rad + self.right_rad) / 2


@dataclass(frozen=True)
class Spin:
    """A turn on the spot, and the angles of the wheels."""

    left_rad: float
    """The angle by which the left wheels have turned, in radians."""
    right_rad: float
    """The angle by which the right wheels have turned, in radians."""
    turn_rad: float
    """The measured angle by which the robot has turned, in radians, positive to the left."""
    deviation_rad: float
    """The standard deviation of this angle, in radians."""

    @property
    def difference_rad(self) -> float:
        """The difference of the angles of the wheels, right minus left, in radians."""
        return self.right_rad - self.left_rad


def fit_radius(drives: Sequence[StraightDrive], present_m: float) -> Estimate:
    """Return the mean radius of the wheels in metres.

    present_m: the radius in the robot's file, in metres.

    Raises CalibrationError if the wheels have not turned, or if the radius is impossible.
    """
    if min(abs(each.mean_rad) for each in drives) < MIN_WHEEL_RAD:
        raise CalibrationError(
            f"the wheels have turned by {min(abs(each.mean_rad) for each in drives):.2f} rad only. Check that nothing "
            "blocks the robot, and its motors and encoders with robotcore test-devices",
            kind="no-motion",
        )
    weights = np.array([1 / each.deviation_m for each in drives])
    angles, ways = (np.array([getattr(each, name) for each in drives]) for name in ("mean_rad", "way_m"))
    (radius,) = fit_linear((angles * weights)[:, None], ways * weights, least_variance=1.0).estimates
    return _require_plausible("the wheel radius", radius, present_m)


def fit_track(spins: Sequence[Spin], radius: Estimate, present_m: float) -> Estimate:
    """Return the track in metres, which is the effective track of wheels that skid.

    radius: the wheel radius in metres.
    present_m: the track by the robot's file, in metres.

    Raises CalibrationError as `fit_radius`.
    """
    if min(abs(each.difference_rad) for each in spins) < 2 * MIN_WHEEL_RAD:
        raise CalibrationError(
            "the wheels have hardly turned. Check that nothing blocks the robot, and its motors and encoders with "
            "robotcore test-devices",
            kind="no-motion",
        )
    weights = np.array([1 / (each.deviation_rad * present_m) for each in spins])
    turns, ways = (
        np.array([each.turn_rad for each in spins]),
        radius.value * np.array([e.difference_rad for e in spins]),
    )
    (track,) = fit_linear((turns * weights)[:, None], ways * weights, least_variance=1.0).estimates
    share = math.hypot(track.deviation / track.value, radius.deviation / radius.value) if track.value else math.inf
    return _require_plausible("the track", Estimate(track.value, share * abs(track.value)), present_m)


def fit_radius_ratio(
    drives: Sequence[StraightDrive], track_m: float, heading_rad: float = ALIGNMENT_RAD
) -> Estimate | None:
    """Return the radius of the right wheel, divided by that of the left wheel; None if no turn was measured.

    heading_rad: the standard deviation of the direction in which the robot began a drive, in radians. Each straight
        drive has its own error.
    """
    ratios = [
        (each.way_m + each.turn_rad * track_m / 2) / (each.way_m - each.turn_rad * track_m / 2)
        * each.left_rad / each.right_rad
        for each in drives
        if each.turn_rad is not None and each.left_rad and each.right_rad
    ]  # fmt: skip
    if not ratios:
        return None
    way = min(abs(each.way_m) for each in drives)
    return Estimate(float(np.mean(ratios)), 2 * heading_rad * track_m / way / math.sqrt(len(ratios)))


def _require_plausible(name: str, length: Estimate, present_m: float) -> Estimate:
    if not present_m / MAX_CHANGE < length.value < present_m * MAX_CHANGE:
        raise CalibrationError(
            f"{name} was measured as {length.value:.4g} m, but the file has {present_m:g} m. Check the measurement "
            "and the directions of the motors and the encoders (robotcore test-devices). If the file is that wrong, "
            "correct it by hand first",
            kind="implausible",
            measured_m=length.value,
            file_m=present_m,
        )
    return length
