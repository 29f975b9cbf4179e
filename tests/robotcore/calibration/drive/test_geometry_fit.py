from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.calibration.drive.geometry_fit import (
    Spin,
    StraightDrive,
    fit_radius,
    fit_radius_ratio,
    fit_track,
)
from robotcore.calibration.drive.straight_path import StraightPath
from robotcore.calibration.least_squares import Array, Estimate
from robotcore.errors import CalibrationError
from robotcore.geometry import Pose
from tests.texts import Raises

LEFT_M, RIGHT_M, TRACK_M = 0.0320, 0.0324, 0.152


def roll(left_rad: Array, right_rad: Array, left_m: float, right_m: float) -> Pose:
    """Return the true pose after a drive."""
    pose = Pose(0.0, 0.0, 0.0)
    for left, right in zip(np.diff(left_rad) * left_m, np.diff(right_rad) * right_m, strict=True):
        pose = pose.advance((left + right) / 2, (right - left) / TRACK_M)
    return pose


def drive(left_rad: float, right_rad: float) -> StraightDrive:
    left, right = np.array([0.0, left_rad]), np.array([0.0, right_rad])
    end = roll(left, right, LEFT_M, RIGHT_M)
    return StraightPath(left, right, end.x, end.y, 0.003).fit((LEFT_M + RIGHT_M) / 2 / TRACK_M)


def spin(left_rad: float, right_rad: float) -> Spin:
    return Spin(left_rad, right_rad, (right_rad * RIGHT_M - left_rad * LEFT_M) / TRACK_M, math.radians(1))


def test_radius_track_and_the_ratio_of_unequal_wheels_are_found() -> None:
    drives = [drive(60.0, 60.0), drive(-60.0, -60.0)]
    radius = fit_radius(drives, 0.0325)
    assert radius.value == pytest.approx((LEFT_M + RIGHT_M) / 2, rel=1e-3)
    track = fit_track([spin(-75.0, 75.0), spin(75.0, -75.0)], radius, 0.155)
    assert track.value == pytest.approx(TRACK_M, rel=1e-3)
    ratio = fit_radius_ratio(drives, track.value)
    assert ratio
    assert ratio.value == pytest.approx(RIGHT_M / LEFT_M, rel=1e-3)


def test_the_deviations_are_those_of_the_reference() -> None:
    radius = fit_radius([StraightDrive(62.0, 62.0, 2.0, 0.003)], 0.0325)
    assert radius.deviation == pytest.approx(0.003 / 62.0, rel=0.01)
    track = fit_track([Spin(-75.0, 75.0, 10 * math.pi, 0.02)], Estimate(0.0325, 0.0), 0.155)
    assert track.deviation == pytest.approx(track.value * 0.02 / (10 * math.pi), rel=0.05)


def test_without_measured_turns_there_is_no_ratio() -> None:
    assert fit_radius_ratio([StraightDrive(62.0, 62.0, 2.0, 0.003)], 0.155) is None


@pytest.mark.parametrize(
    "way, angle, kind", [(0.02, 1.0, "no-motion"), (5.0, 62.0, "implausible"), (-2.0, 62.0, "implausible")]
)
def test_an_impossible_radius_is_an_error(way: float, angle: float, kind: str, raises: Raises) -> None:
    with raises(CalibrationError, kind):
        fit_radius([StraightDrive(angle, angle, way, 0.003)], 0.0325)


@pytest.mark.parametrize("turn, angle, kind", [(30.0, 1.0, "no-motion"), (-30.0, 75.0, "implausible")])
def test_an_impossible_track_is_an_error(turn: float, angle: float, kind: str, raises: Raises) -> None:
    with raises(CalibrationError, kind):
        fit_track([Spin(-angle, angle, turn, 0.02)], Estimate(0.0325, 0.0), 0.155)


@pytest.mark.parametrize("turn", [-1.2, -0.01, 0.0, 0.5, 2.0])
def test_an_arc_of_unequal_wheels_has_its_length_and_its_angle(turn: float) -> None:
    end, wheels = Pose(0.0, 0.0, 0.0).advance(1.5, turn), np.array([0.0, 45.0])
    found = StraightPath(wheels, wheels, end.x, end.y, 0.003).fit(0.2)
    assert (found.way_m, found.turn_rad) == pytest.approx((1.5, turn))


def follow(lag_s: float, speed_rad_s: float, duration_s: float) -> Array:
    """Return the angles of a wheel that starts and stops with a lag, (samples,) in radians."""
    times = np.arange(0.0, duration_s + 1.5, 0.01)
    start, stop = (np.maximum(times - each, 0.0) for each in (0.0, duration_s))
    return np.asarray(
        speed_rad_s * (start + lag_s * np.expm1(-start / lag_s) - stop - lag_s * np.expm1(-stop / lag_s)), np.float64
    )


@pytest.mark.parametrize("duration", [3.0, 10.0])
@pytest.mark.parametrize("speed", [6.0, -6.0])
@pytest.mark.parametrize("radii", [(0.0334, 0.0334), (LEFT_M, RIGHT_M)], ids=["equal", "unequal"])
def test_lags_that_differ_change_neither_the_radius_nor_the_ratio(
    duration: float, speed: float, radii: tuple[float, float]
) -> None:
    left, right = follow(0.15, speed, duration), follow(0.05, speed, duration)
    end = roll(left, right, *radii)
    found = StraightPath(left, right, end.x, end.y, 0.003).fit(sum(radii) / 2 / TRACK_M)
    assert fit_radius([found], 0.0325).value == pytest.approx(sum(radii) / 2, rel=2e-4)
    ratio = fit_radius_ratio([found], TRACK_M)
    assert ratio
    assert ratio.value == pytest.approx(radii[1] / radii[0], rel=2e-4)


def test_the_distance_to_a_wall_is_compared_with_the_way_towards_it() -> None:
    left, right = follow(0.15, 6.0, 5.0), follow(0.05, 6.0, 5.0)
    end = roll(left, right, 0.0334, 0.0334)
    found = StraightPath(left, right, end.x, None, 0.005).fit(0.0334 / TRACK_M)
    assert found.turn_rad is None
    assert found.way_m == pytest.approx(0.0334 * found.mean_rad)
    assert end.x < 0.995 * found.way_m


def test_wheels_that_did_not_turn_have_no_way() -> None:
    stands = np.zeros(5)
    assert StraightPath(stands, stands, 0.4, 0.1, 0.003).fit(0.2).way_m == 0.0
    assert StraightPath(stands, stands, 0.4, None, 0.003).fit(0.2).way_m == 0.0
