from __future__ import annotations

import math

import pytest

from robotcore.calibration.drive.geometry_fit import (
    Spin,
    StraightDrive,
    bend_arc,
    fit_radius,
    fit_radius_ratio,
    fit_track,
)
from robotcore.calibration.excitation_runs import Displacement
from robotcore.calibration.least_squares import Estimate
from robotcore.errors import CalibrationError
from robotcore.geometry import Pose
from tests.texts import Raises

LEFT_M, RIGHT_M, TRACK_M = 0.0320, 0.0324, 0.152


def drive(left_rad: float, right_rad: float) -> StraightDrive:
    left, right = left_rad * LEFT_M, right_rad * RIGHT_M
    end = Pose(0.0, 0.0, 0.0).advance((left + right) / 2, (right - left) / TRACK_M)
    way, turn = bend_arc(Displacement(end.x, end.y))
    return StraightDrive(left_rad, right_rad, way, 0.003, turn)


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
def test_an_arc_has_its_length_and_its_angle(turn: float) -> None:
    end = Pose(0.0, 0.0, 0.0).advance(1.5, turn)
    assert bend_arc(Displacement(end.x, end.y)) == pytest.approx((1.5, turn))
