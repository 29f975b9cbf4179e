from __future__ import annotations

import pytest

from robotcore.calibration.least_squares import Estimate
from robotcore.calibration.motors.velocity_curve import CurvePoint, fit_velocity_curve
from robotcore.errors import CalibrationError
from robotcore.hardware.motor_model import MotorModel
from tests.texts import Raises

MODEL = MotorModel(dead_band=0.2, forward_rad_s=10.0, backward_rad_s=12.0)
LEVELS = (1.0, 0.8, 0.6, 0.4)


def list_points(model: MotorModel = MODEL, levels: tuple[float, ...] = LEVELS) -> list[CurvePoint]:
    commands = [sign * level for level in levels for sign in (1, -1)]
    return [CurvePoint(each, Estimate(model.velocity(each), 0.01)) for each in commands]


def test_the_curve_goes_through_exact_points() -> None:
    curve = fit_velocity_curve(list_points())
    assert (curve.dead_band.value, curve.forward.value, curve.backward.value) == pytest.approx((0.2, 10, 12), rel=1e-4)
    assert curve.r_squared == pytest.approx(1)
    assert curve.is_fitting


def test_duties_at_which_the_wheel_stands_or_hardly_turns_are_left_out() -> None:
    standing = [CurvePoint(0.1, Estimate(0.0, 0.01)), CurvePoint(-0.25, Estimate(-0.01, 0.01))]
    curve = fit_velocity_curve([*list_points(), *standing])
    assert curve.dead_band.value == pytest.approx(0.2, rel=1e-3)
    assert len(curve.points) == 10


@pytest.mark.parametrize("direction", ["forward", "backward"])
def test_a_wheel_that_turns_in_one_direction_only_is_an_error(direction: str, raises: Raises) -> None:
    sign = -1 if direction == "forward" else 1
    with raises(CalibrationError, "too-few-points", direction=direction):
        fit_velocity_curve([each for each in list_points() if each.command * sign > 0])


def test_a_dead_band_beyond_the_limit_of_the_fit_is_an_error(raises: Raises) -> None:
    model = MotorModel(dead_band=0.95, forward_rad_s=10.0, backward_rad_s=12.0)
    with raises(CalibrationError, "parameter-at-limit", parameter="dead_band", limit=0.9):
        fit_velocity_curve(list_points(model, (1.0, 0.98, 0.96)))


def test_velocities_that_do_not_grow_with_the_duty_do_not_fit() -> None:
    blocked = [
        CurvePoint(each.command, Estimate(3.0 if each.command > 0.5 else each.velocity.value, 0.01))
        for each in list_points()
    ]
    assert not fit_velocity_curve(blocked).is_fitting
