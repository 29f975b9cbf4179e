"""Least squares with standard deviations: linear, and by Gauss-Newton steps for a few parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.errors import CalibrationError

Array = NDArray[np.float64]

MAX_STEPS = 60
"""The greatest number of Gauss-Newton steps."""

TOLERANCE = 1e-9
"""The fit ends if a step changes the sum of squares by less than this share."""

MAX_DIGITS = 4
"""No value of a robot has more meaningful digits, because batteries, tyres and motors change."""

AT_LIMIT = 1e-6
"""A parameter is at a limit if it differs from it by less than this share of the distance between its limits."""

DIFFERENCE = 1e-4
"""The step of the numeric derivative, as a share of a parameter's scale."""


def round_measured(value: float, uncertainty: float) -> float:
    """Return a measured value without the digits that its uncertainty makes meaningless.

    The last digit that stays is the second one of the uncertainty, so that rounding adds no error of importance.

    uncertainty: the standard deviation of the value, in the unit of the value. With 0, six digits stay.

    >>> round_measured(13.28517, 0.0317), round_measured(0.0325, 0.0), round_measured(13.28517, 4.0)
    (13.285, 0.0325, 13.3)
    """
    if not (math.isfinite(value) and math.isfinite(uncertainty)) or value == 0:
        return value
    scale = abs(uncertainty) or abs(value) * 1e-4
    return round(value, 1 - math.floor(math.log10(scale)))


def format_digits(value: float, digits: int) -> str:
    """Return a number with a number of meaningful digits, and without an exponent.

    >>> format_digits(1.3e-05, 2), format_digits(0.0076, 2), format_digits(140.0, 4), format_digits(0.0, 2)
    ('0.000013', '0.0076', '140', '0')
    """
    return np.format_float_positional(value, precision=digits, fractional=False, trim="-")


class Estimate(NamedTuple):
    """A measured value and its uncertainty.

    >>> Estimate(13.28517, 0.0317).rounded, Estimate(13.28517, 0.0).rounded
    (13.29, 13.29)
    """

    value: float
    """The measured value."""
    deviation: float
    """The standard deviation, in the unit of the value."""

    @property
    def rounded(self) -> float:
        """The value with the digits that its uncertainty allows, and with `MAX_DIGITS` digits at most."""
        if not self.value or not math.isfinite(self.value):
            return self.value
        most = MAX_DIGITS - 1 - math.floor(math.log10(abs(self.value)))
        return round(round_measured(self.value, self.deviation), most)

    def scale(self, factor: float) -> Estimate:
        """Return the estimate of the value times a known factor."""
        return Estimate(self.value * factor, self.deviation * abs(factor))


@dataclass(frozen=True)
class Fit:
    """The parameters that minimise the sum of the squared residuals."""

    parameters: Array
    covariance: Array
    """The covariance of the parameters, with the variance of the residuals as that of the noise."""
    residuals: Array
    reached: tuple[float | None, ...] = ()
    """The upper limit at which each parameter has ended; None for a parameter below its limit. Empty without limits."""

    def require_below_limits(self, names: Sequence[str], remedy: str) -> None:
        """Raise CalibrationError if a parameter is at its upper limit, because the true value is then beyond it.

        names: the keys of the parameters.
        remedy: an instruction for the user, as a sentence without its full stop.
        """
        for name, limit in zip(names, self.reached, strict=True):
            if limit is not None:
                raise CalibrationError(
                    f"{name} is at the limit of the fit, {limit:g}, so that all measured values may be wrong. {remedy}",
                    kind="parameter-at-limit",
                    parameter=name,
                    limit=limit,
                )

    @property
    def estimates(self) -> list[Estimate]:
        """The parameters with their standard deviations."""
        deviations = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return [Estimate(float(value), float(each)) for value, each in zip(self.parameters, deviations, strict=True)]


def fit_linear(columns: Array, values: Array, *, least_variance: float = 0.0) -> Fit:
    """Return the factors of the columns whose sum is nearest to the values.

    columns: the values of each function, (samples, factors).
    values: the measured values, (samples,).
    least_variance: as for `fit_nonlinear`.
    """
    inverse = np.asarray(np.linalg.pinv(columns.T @ columns), np.float64)
    factors = inverse @ (columns.T @ values)
    residuals = values - columns @ factors
    return Fit(factors, inverse * _estimate_variance(residuals, len(factors), least_variance), residuals)


def fit_nonlinear(
    residuals: Callable[[Array], Array], start: Array, lower: Array, upper: Array, *, least_variance: float = 0.0
) -> Fit:
    """Return the parameters within limits that minimise the sum of the squared residuals, by damped Gauss-Newton steps.

    residuals: returns the residuals for parameters, (samples,).
    start: the first parameters.
    lower, upper: the limits of the parameters, each finite.
    least_variance: the known variance of the residuals. The covariance is computed with a larger one if the residuals
        are larger.
    """
    scale = np.maximum(np.abs(start), 1e-3 * (upper - lower))
    here, damping = np.clip(start, lower, upper), 1e-3
    now = residuals(here)
    slope = _differentiate(residuals, here, scale, upper)
    for _ in range(MAX_STEPS):
        there = _step(here, slope, now, damping, lower, upper)
        then = residuals(there)
        gain = float(now @ now - then @ then)
        if gain <= 0:
            damping *= 10
            if damping > 1e9:
                break
            continue
        is_last = gain < TOLERANCE * float(now @ now)
        here, now, damping = there, then, damping / 10
        slope = _differentiate(residuals, here, scale, upper)
        if is_last:
            break
    inverse = np.asarray(np.linalg.pinv(slope.T @ slope), np.float64)
    is_reached = here >= upper - AT_LIMIT * (upper - lower)
    reached = tuple(float(limit) if each else None for each, limit in zip(is_reached, upper, strict=True))
    return Fit(here, inverse * _estimate_variance(now, len(here), least_variance), now, reached)


def _step(here: Array, slope: Array, now: Array, damping: float, lower: Array, upper: Array) -> Array:
    """Return the parameters after a damped Gauss-Newton step within the limits.

    A parameter stays at a limit if the sum of squares falls beyond the limit. A parameter that the step would move
    beyond a limit is moved to the limit. The step of the others is computed again, because together with the shortened
    step it may lead uphill.
    """
    step, gradient = np.zeros_like(here), slope.T @ now
    is_free = ~(((here <= lower) & (gradient > 0)) | ((here >= upper) & (gradient < 0)))
    while is_free.any():
        part = slope[:, is_free]
        normal = part.T @ part
        rest = now + slope[:, ~is_free] @ step[~is_free]
        step[is_free] = -np.linalg.pinv(normal + damping * np.diag(np.diag(normal))) @ (part.T @ rest)
        within = np.clip(here + step, lower, upper) - here
        is_beyond = is_free & (within != step)
        step = within
        if not is_beyond.any():
            break
        is_free &= ~is_beyond
    there: Array = here + step
    return np.clip(there, lower, upper)


def _differentiate(residuals: Callable[[Array], Array], here: Array, scale: Array, upper: Array) -> Array:
    columns = []
    for number, size in enumerate(scale * DIFFERENCE):
        step = np.zeros_like(here)
        step[number] = -size if here[number] + size > upper[number] else size
        columns.append((residuals(here + step) - residuals(here)) / step[number])
    return np.column_stack(columns)


def _estimate_variance(residuals: Array, parameters: int, least: float) -> float:
    """Return the variance of the noise, increased as if only the independent ones of the residuals were measured.

    Neighbouring residuals are alike if the resolution of a sensor, and not its noise, makes them.
    """
    free = len(residuals) - parameters
    if free < 1:
        return least or float("inf")
    total = float(residuals @ residuals)
    alike = float(residuals[1:] @ residuals[:-1]) / total if total else 0.0
    likeness = min(max(alike, 0.0), 0.98)
    return max(total / free * (1 + likeness) / (1 - likeness), least)
