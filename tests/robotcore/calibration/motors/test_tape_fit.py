from __future__ import annotations

import math
from random import Random

import pytest

from robotcore.calibration.excitation_runs import Displacement
from robotcore.calibration.motors.tape_fit import PresentMotor, TapeDrive, fit_tape
from robotcore.errors import CalibrationError
from robotcore.geometry import DifferentialGeometry, Pose
from robotcore.hardware.motor_model import MotorModel
from tests.texts import Raises

GEOMETRY = DifferentialGeometry(0.0325, 0.155)
LEFT = MotorModel(dead_band=0.08, forward_rad_s=13.0, backward_rad_s=14.5)
RIGHT = MotorModel(dead_band=0.17, forward_rad_s=14.4, backward_rad_s=13.1)
PRESENT = PresentMotor(0.1, 14.0, 14.0, 0.05)


def drive(command: float, duration: float, lags: tuple[float, float], noise: Random | None = None) -> TapeDrive:
    """Return where a robot is after a drive, by integration in steps of a millisecond."""
    pose, speeds = Pose(0.0, 0.0, 0.0), [0.0, 0.0]
    for tick in range(round(1000 * (duration + 2.0))):
        for wheel, (model, lag) in enumerate(zip((LEFT, RIGHT), lags, strict=True)):
            target = model.velocity(command) if tick < 1000 * duration else 0.0
            speeds[wheel] += (target - speeds[wheel]) * -math.expm1(-0.001 / lag)
        left, right = (speed * GEOMETRY.wheel_radius * 0.001 for speed in speeds)
        pose = pose.advance((left + right) / 2, (right - left) / GEOMETRY.track)
    x, y = (each + (noise.gauss(0.0, 0.002) if noise else 0.0) for each in pose[:2])
    return TapeDrive(command, duration, Displacement(x, y))


PLAN = tuple((sign * level, way) for level, way in ((1.0, 2.2), (0.75, 1.5), (0.5, 5.0)) for sign in (1, -1))


@pytest.mark.parametrize(
    "lags, noise, error", [((0.05, 0.05), None, 0.002), ((0.05, 0.08), None, 0.02), ((0.06, 0.06), Random(3), 0.06)]
)
def test_both_motors_are_found_from_displacements(
    lags: tuple[float, float], noise: Random | None, error: float
) -> None:
    curves = fit_tape([drive(*each, lags, noise) for each in PLAN], GEOMETRY, [PRESENT, PRESENT])
    for curve, model in zip(curves, (LEFT, RIGHT), strict=True):
        assert curve.dead_band.value == pytest.approx(model.dead_band, rel=error)
        assert curve.forward.value == pytest.approx(model.forward_rad_s, rel=error / 3 + 0.001)
        assert curve.backward.value == pytest.approx(model.backward_rad_s, rel=error / 3 + 0.001)
        assert curve.is_fitting
        assert [each.command for each in curve.points] == [command for command, _ in PLAN]


def test_one_motor_of_both_wheels_is_found() -> None:
    ways = [
        TapeDrive(command, duration, Displacement(LEFT.velocity(command) * GEOMETRY.wheel_radius * duration, 0.0))
        for command, duration in PLAN
    ]
    (curve,) = fit_tape(ways, GEOMETRY, [PRESENT])
    assert curve.dead_band.value == pytest.approx(0.08, rel=0.01)
    assert curve.forward.value == pytest.approx(13.0, rel=0.002)


def test_a_velocity_far_beyond_that_of_the_file_is_an_error(raises: Raises) -> None:
    slow = PresentMotor(0.1, 1.0, 1.0, 0.05)
    drives = [drive(*each, (0.05, 0.05)) for each in PLAN]
    with raises(CalibrationError, "parameter-at-limit", parameter="forward_rad_s of the left motor", limit=10.0):
        fit_tape(drives, GEOMETRY, [slow, slow])


def test_distances_of_no_motor_are_an_error(raises: Raises) -> None:
    drives = [drive(*each, (0.05, 0.05)) for each in PLAN]
    drives[2] = drives[2]._replace(moved=Displacement(2 * drives[2].moved.forward_m, drives[2].moved.left_m))
    with raises(CalibrationError, "poor-fit", hide=["0.290"]):
        fit_tape(drives, GEOMETRY, [PRESENT, PRESENT])


def test_a_robot_that_does_not_move_is_an_error(raises: Raises) -> None:
    still = [each._replace(moved=Displacement(0.004, 0.0)) for each in [drive(*PLAN[0], (0.05, 0.05))]]
    with raises(CalibrationError, "no-motion"):
        fit_tape(still, GEOMETRY, [PRESENT, PRESENT])
