"""Fits the velocity of a wheel at each step of its command, and the lag with which the wheel follows the steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotcore.calibration.corrections import DEVIATIONS
from robotcore.calibration.excitation import CommandStep
from robotcore.calibration.least_squares import Array, Estimate, Fit, fit_linear, fit_nonlinear
from robotcore.errors import CalibrationError

STARTS_S = ((0.02, 0.0), (0.08, 0.0), (0.3, 0.0))
"""The lags and delays in seconds from which the fit begins."""

MIN_LAG_S, MAX_LAG_S = 1e-3, 3.0
"""The limits of the lag in seconds. A shorter one cannot be distinguished from none, and counts as none."""

LEAST_DIFFERENCE_S = 0.01
"""The least difference of the lags of both sides that counts, in seconds."""

MAX_DELAY_S = 0.5
"""The greatest delay in seconds."""

MAX_LAG_ERROR, MAX_LAG_ERROR_S = 0.1, 0.05
"""The greatest standard deviation of the lag: this share of the lag, or these seconds if they are longer. The
velocities that a wheel with a long lag would reach are as uncertain as the lag."""

Numbers = NDArray[np.int_]

MIN_SAMPLES = 5
"""The least number of samples in a step."""


@dataclass(frozen=True)
class Response:
    """How a wheel responds to the steps of its command."""

    velocities: tuple[tuple[CommandStep, Estimate], ...]
    """Each step with a command other than 0, and the velocity in rad/s that the wheel reaches in it."""
    lag: Estimate
    """The time constant of the first-order lag, in seconds."""
    delay: Estimate
    """The time from a command to the first effect, in seconds."""
    residual_rad: float
    """The root mean square of the angle's residuals, in radians."""


def fit_response(steps: Sequence[CommandStep], times: Array, angles: Array, *, has_drift: bool = False) -> Response:
    """Return the response of a wheel that follows its command with a delay and a first-order lag.

    The velocity of each step is free, so that the fit needs no model of the motor. The angle has an offset in each
    step, so that an error in one step has no effect on the others. With the command 0 the wheel stands in the end.

    steps: the steps of the command in the order of time, without gaps.
    times: the times of the samples, (samples,) in seconds.
    angles: the angles of the wheel, (samples,) in radians.
    has_drift: whether the angle also drifts at a constant rate, as that of a gyroscope does.

    Raises CalibrationError if a step has too few samples, or if the lag or the delay is too long to be measured.
    """
    number: Numbers = np.searchsorted([step.start for step in steps], times, side="right") - 1
    used = (number >= 0) & (times <= steps[-1].end)
    number, times, angles = number[used], times[used], angles[used]
    counts: Numbers = np.bincount(number, minlength=len(steps))
    if counts.min() < MIN_SAMPLES:
        raise CalibrationError(
            f"a step of the command has only {counts.min()} samples of the angle. Let the sensor measure more often",
            kind="too-few-samples",
        )
    driven = [step for step in steps if step.command]

    def solve(parameters: Array) -> Fit:
        lag, delay = parameters
        after = [times - step.start - delay for step in driven], [times - step.end - delay for step in driven]
        columns = [compute_step_response(a, lag) - compute_step_response(b, lag) for a, b in zip(*after, strict=True)]
        table = np.column_stack([*columns, *([times] if has_drift else []), angles])
        free = _remove_offsets(table, number, counts)
        return fit_linear(free[:, :-1], free[:, -1])

    lower, upper = np.array([MIN_LAG_S, 0.0]), np.array([MAX_LAG_S, MAX_DELAY_S])
    starts = (np.array(each) for each in STARTS_S)
    best = min(starts, key=lambda start: float(np.sum(solve(start).residuals ** 2)))
    timing = fit_nonlinear(lambda parameters: solve(parameters).residuals, best, lower, upper)
    timing.require_below_limits(
        ("lag_s", "delay_s"),
        "Charge the battery, and check that the wheels turn freely and that the sensor measures in time. A motor with "
        f"a lag above {MAX_LAG_S:g} s or a delay above {MAX_DELAY_S:g} s cannot be measured",
    )
    lag = _estimate_lag(timing)
    if lag.deviation > max(MAX_LAG_ERROR * lag.value, MAX_LAG_ERROR_S):
        raise CalibrationError(
            f"the lag is {lag.value:.2f} ± {lag.deviation:.2f} s, which is too uncertain, because the wheel reaches no "
            "constant velocity. Charge the battery, check that the wheels turn freely, or use a finer encoder",
            kind="uncertain-lag",
            lag_s=lag.value,
            deviation_s=lag.deviation,
        )
    fit = solve(timing.parameters)
    rms = float(np.sqrt(np.mean(fit.residuals**2)))
    return Response(tuple(zip(driven, fit.estimates, strict=False)), lag, timing.estimates[1], rms)


def _estimate_lag(timing: Fit) -> Estimate:
    """Return the lag of a fit of the lag and the delay.

    Samples at a low rate show the sum of a short lag and a delay only. As no delay is negative, the lag is at most
    this sum.
    """
    lag, delay = timing.estimates
    most = lag.value + delay.value + math.sqrt(max(float(timing.covariance.sum()), 0.0))
    deviation = min(lag.deviation, most)
    return Estimate(0.0, max(deviation, MIN_LAG_S)) if lag.value <= MIN_LAG_S else Estimate(lag.value, deviation)


def find_lag_difference_s(left: Sequence[Response], right: Sequence[Response]) -> float:
    """Return by how many seconds the left wheels follow a command later than the right ones; 0.0 without a difference.

    A difference that is uncertain, or so short that it hardly turns the robot, counts as none.

    left, right: the responses of the motors of each side.
    """
    starts = [[each.lag.value + each.delay.value for each in side] for side in (left, right)]
    difference = float(np.mean(starts[0]) - np.mean(starts[1]))
    deviations = [each for response in (*left, *right) for each in (response.lag.deviation, response.delay.deviation)]
    is_clear = abs(difference) > max(LEAST_DIFFERENCE_S, DEVIATIONS * math.hypot(*deviations))
    return difference if is_clear else 0.0


def shorten_rests(steps: Sequence[CommandStep], duration_s: float) -> list[CommandStep]:
    """Return steps whose rests before the first command and after the last one are at most ``duration_s`` long."""
    first, *middle, last = steps
    first = first._replace(start=max(first.start, first.end - duration_s))
    return [first, *middle, last._replace(end=min(last.end, last.start + duration_s))]


def compute_step_response(passed: Array, lag: float) -> Array:
    """Return the angle of a wheel after times since its command was set to 1 rad/s, in radians; 0 before that.

    passed: the times in seconds, (n,).
    lag: the time constant of the first-order lag, in seconds.
    """
    positive = np.maximum(passed, 0.0)
    return positive - lag * -np.expm1(-positive / lag)


def _remove_offsets(columns: Array, number: Numbers, counts: Numbers) -> Array:
    """Return columns from which their mean in each step is subtracted.

    number: the number of the step of each sample.
    counts: the number of the samples in each step.
    """
    sums = np.zeros((len(counts), columns.shape[1]))
    np.add.at(sums, number, columns)
    result: Array = columns - (sums / counts[:, None])[number]
    return result
