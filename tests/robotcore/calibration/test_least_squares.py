from __future__ import annotations

import numpy as np
import pytest

from robotcore.calibration.least_squares import Estimate, fit_linear, fit_nonlinear, round_measured
from robotcore.errors import CalibrationError
from tests.texts import Raises

X = np.linspace(0.0, 1.0, 400)


def test_a_line_is_found_with_the_deviation_of_its_noise() -> None:
    found = []
    for seed in range(60):
        noise = np.random.default_rng(seed).normal(0, 0.1, len(X))
        found.append(fit_linear(np.column_stack([np.ones_like(X), X]), 2 + 3 * X + noise).estimates[1])
    scatter = np.std([each.value for each in found])
    assert np.mean([each.value for each in found]) == pytest.approx(3, abs=0.02)
    assert np.mean([each.deviation for each in found]) == pytest.approx(scatter, rel=0.3)


def test_residuals_that_are_alike_count_as_fewer_measurements() -> None:
    noise = np.random.default_rng(1).normal(0, 0.1, len(X) // 20).repeat(20)
    (alike,) = fit_linear(np.ones((len(X), 1)), noise).estimates
    (independent,) = fit_linear(np.ones((len(X), 1)), np.random.default_rng(1).permutation(noise)).estimates
    assert alike.deviation > 3 * independent.deviation


def test_the_known_variance_holds_without_residuals() -> None:
    (mean,) = fit_linear(np.ones((4, 1)), np.full(4, 2.0), least_variance=0.04).estimates
    assert mean == pytest.approx((2.0, 0.1))


def test_a_curve_is_found_from_a_distant_start() -> None:
    fit = fit_nonlinear(
        lambda p: p[0] * np.exp(-X / p[1]) - 5 * np.exp(-X / 0.2),
        np.array([1.0, 0.9]),
        np.array([0.0, 0.01]),
        np.array([50.0, 2.0]),
    )
    assert fit.parameters == pytest.approx([5.0, 0.2], rel=1e-5)


def test_parameters_stay_within_their_limits() -> None:
    fit = fit_nonlinear(lambda p: p[0] * X + 1, np.array([1.0]), np.array([0.0]), np.array([2.0]))
    assert fit.parameters == pytest.approx([0.0])


def test_a_parameter_at_its_upper_limit_is_an_error(raises: Raises) -> None:
    fit = fit_nonlinear(lambda p: p[0] * X - 9 * X, np.array([1.0]), np.array([0.0]), np.array([2.0]))
    assert fit.reached == (2.0,)
    with raises(CalibrationError, "parameter-at-limit", parameter="gain", limit=2.0):
        fit.require_below_limits(["gain"], "Measure again")


def test_a_value_is_rounded_to_its_meaningful_digits() -> None:
    assert (Estimate(0.0500049, 1e-6).rounded, Estimate(0.16004, 1e-9).rounded) == (0.05, 0.16)
    assert Estimate(12.3456, 0.2).rounded == 12.35
    assert Estimate(2.0, 0.1).scale(-2) == (-4.0, 0.2)


@pytest.mark.parametrize(
    "value, uncertainty, rounded",
    [
        (13.28517, 0.0317, 13.285),
        (0.032512, 0.00021, 0.03251),
        (-1234.5, 210.0, -1230.0),
        (0.15, 0.0, 0.15),
        (0.0, 1.0, 0.0),
    ],
)
def test_a_measured_value_has_the_digits_that_its_uncertainty_allows(
    value: float, uncertainty: float, rounded: float
) -> None:
    assert round_measured(value, uncertainty) == rounded
