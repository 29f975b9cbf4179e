from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.calibration.excitation import CommandStep
from robotcore.calibration.motors.plans import LEVELS
from robotcore.calibration.motors.response import find_lag_difference_s, fit_response, shorten_rests
from robotcore.calibration.motors.velocity_curve import CurvePoint, fit_velocity_curve
from robotcore.errors import CalibrationError
from robotcore.hardware.motor_model import MotorModel
from tests.robotcore.calibration.wheels import list_steps, turn_wheel
from tests.texts import Raises

MODEL = MotorModel(dead_band=0.13, forward_rad_s=12.8, backward_rad_s=14.9)


@pytest.mark.parametrize("lag, delay", [(0.02, 0.0), (0.06, 0.012), (0.15, 0.0)])
def test_the_lag_the_delay_and_each_velocity_are_found(lag: float, delay: float) -> None:
    steps = list_steps((1.0, 0.6, 0.3))
    response = fit_response(steps, *turn_wheel(steps, MODEL, lag, delay))
    assert response.lag.value == pytest.approx(lag, abs=0.0003)
    assert response.delay.value == pytest.approx(delay, abs=0.0006)
    for step, velocity in response.velocities:
        assert velocity.value == pytest.approx(MODEL.velocity(step.command), rel=0.002), step


@pytest.mark.parametrize("lag", [0.0, 0.0002, 0.001, 0.005, 0.05, 0.3, 2.9])
@pytest.mark.parametrize("period_s, edges", [(0.01, 0), (0.01, 3840), (0.05, 3840)])
def test_any_lag_is_found_without_a_delay(lag: float, period_s: float, edges: int) -> None:
    steps = list_steps(LEVELS[::2])
    times, angles = turn_wheel(steps, MODEL, lag, 0.0, math.tau / edges if edges else 0.0, period_s)
    response = fit_response(steps, times, angles)
    assert response.lag.value == pytest.approx(lag, rel=0.02, abs=0.0012 if period_s < 0.05 else 0.005)
    assert abs(response.lag.value - lag) < max(4 * response.lag.deviation, 0.002)
    assert response.velocities[0][1].value == pytest.approx(12.8, rel=0.02)


def test_a_lag_that_a_slow_sensor_cannot_separate_from_a_delay_is_at_most_their_sum() -> None:
    steps = list_steps(LEVELS)
    response = fit_response(steps, *turn_wheel(steps, MODEL, 0.001, 0.012, math.tau / 80, 0.05))
    assert response.lag.value + response.delay.value == pytest.approx(0.013, abs=0.002)
    assert 0.001 < response.lag.deviation < 0.02


@pytest.mark.parametrize("lag, delay, parameter, limit", [(5.0, 0.0, "lag_s", 3.0), (0.05, 0.6, "delay_s", 0.5)])
def test_a_response_that_is_too_slow_is_an_error(
    lag: float, delay: float, parameter: str, limit: float, raises: Raises
) -> None:
    steps = list_steps((1.0, 0.6, 0.3), rest_s=1.0)
    with raises(CalibrationError, "parameter-at-limit", parameter=parameter, limit=limit):
        fit_response(steps, *turn_wheel(steps, MODEL, lag, delay))


def test_a_long_lag_by_a_coarse_encoder_is_an_error(raises: Raises) -> None:
    steps = list_steps(LEVELS)
    with raises(CalibrationError, "uncertain-lag", hide=["2.49", "0.66"]):
        fit_response(steps, *turn_wheel(steps, MODEL, 2.9, 0.0, math.tau / 80))


@pytest.mark.parametrize("edges", [3840, 80, 40])
def test_all_properties_are_found_by_a_coarse_encoder_too(edges: int) -> None:
    steps = list_steps(LEVELS)
    response = fit_response(steps, *turn_wheel(steps, MODEL, 0.07, 0.005, math.tau / edges))
    curve = fit_velocity_curve([CurvePoint(step.command, velocity) for step, velocity in response.velocities])
    assert response.lag.value == pytest.approx(0.07, rel=0.05)
    assert response.lag.deviation < 0.05 * 0.07
    assert curve.dead_band.value == pytest.approx(MODEL.dead_band, rel=0.02)
    assert curve.forward.value == pytest.approx(MODEL.forward_rad_s, rel=0.005)
    assert curve.backward.value == pytest.approx(MODEL.backward_rad_s, rel=0.005)


def test_the_drift_of_a_gyroscope_has_no_effect() -> None:
    steps = list_steps((1.0, 0.5))
    times, angles = turn_wheel(steps, MODEL, 0.06)
    response = fit_response(steps, times, angles + 0.4 * times, has_drift=True)
    assert response.lag.value == pytest.approx(0.06, abs=0.001)
    for step, velocity in response.velocities:
        assert velocity.value == pytest.approx(MODEL.velocity(step.command), rel=0.005)


def test_a_bump_in_one_step_does_not_change_the_velocities_of_the_others() -> None:
    steps = list_steps((1.0, 0.6, 0.3))
    times, angles = turn_wheel(steps, MODEL, 0.05)
    bump = np.where(times > (steps[1].start + steps[1].end) / 2, 0.3, 0.0)
    response = fit_response(steps, times, angles + bump)
    for step, velocity in response.velocities[2:]:
        assert velocity.value == pytest.approx(MODEL.velocity(step.command), rel=0.02)


def test_a_step_without_samples_is_an_error(raises: Raises) -> None:
    steps = list_steps((1.0,))
    times, angles = turn_wheel(steps, MODEL, 0.05, period_s=0.25)
    with raises(CalibrationError, "too-few-samples"):
        fit_response(steps, times, angles)


def test_long_rests_are_shortened_on_the_side_of_the_steps() -> None:
    steps = [CommandStep(0.0, 9.0, 0.0), CommandStep(9.0, 10.0, 1.0), CommandStep(10.0, 20.0, 0.0)]
    assert shorten_rests(steps, 2.0) == [steps[0]._replace(start=7.0), steps[1], steps[2]._replace(end=12.0)]


@pytest.mark.parametrize(
    "left, right, edges, expected",
    [
        ((0.09, 0.0), (0.05, 0.0), 3840, 0.04),
        ((0.05, 0.0), (0.05, 0.03), 3840, -0.03),
        ((0.058, 0.0), (0.05, 0.0), 3840, 0.0),
        ((0.1, 0.0), (0.05, 0.0), 5, 0.0),
    ],
    ids=["lags", "delays", "short", "uncertain"],
)
def test_a_clear_difference_of_the_lags_is_found(
    left: tuple[float, float], right: tuple[float, float], edges: int, expected: float
) -> None:
    steps = list_steps((1.0, 0.6, 0.3))
    one, other = ([fit_response(steps, *turn_wheel(steps, MODEL, *each, math.tau / edges))] for each in (left, right))
    assert find_lag_difference_s(one, other) == pytest.approx(expected, abs=0.001)
