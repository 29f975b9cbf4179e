"""Fits a motor's dead band and its velocities at full duty to the velocities at several duties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.calibration.least_squares import Array, Estimate, fit_nonlinear
from robotcore.errors import CalibrationError

MIN_POINTS = 2
"""The least number of duties in each direction at which the wheel must turn."""

MIN_TURNING = 0.05
"""A wheel that is slower than this share of its greatest velocity may stick, so that the fit leaves the duty out."""

MAX_DEAD_BAND = 0.9

MIN_R_SQUARED = 0.98
"""The least share of the variance of the speeds in each direction that the curve must explain."""

MODEL_ERROR = 0.001
"""The share of the greatest velocity by which a real motor's velocities differ from the curve at least. With it, the
precise velocities of a fine encoder do not outweigh those at other duties."""


class CurvePoint(NamedTuple):
    """The velocity of a wheel at a duty."""

    command: float
    """The duty, or the share of the full command, from -1 to 1."""
    velocity: Estimate
    """The velocity in rad/s."""


@dataclass(frozen=True)
class VelocityCurve:
    """The velocity of a wheel as a function of the duty: 0 in the dead band, and linear above it."""

    dead_band: Estimate
    """The greatest duty at which the wheel does not turn."""
    forward: Estimate
    """The velocity at the duty 1, in rad/s."""
    backward: Estimate
    """The velocity at the duty -1, in rad/s, as a positive number."""
    points: tuple[CurvePoint, ...]
    """The measured points."""
    residual_rad_s: float
    """The root mean square of the residuals, in rad/s."""
    r_squared: float
    """The share of the variance of the speeds in each direction that the curve explains, up to 1."""

    @property
    def is_fitting(self) -> bool:
        """Whether the curve explains the points."""
        return self.r_squared >= MIN_R_SQUARED


def fit_velocity_curve(points: Sequence[CurvePoint]) -> VelocityCurve:
    """Return the curve through points of both directions, with one dead band for both.

    Raises CalibrationError if the wheel turns at fewer than `MIN_POINTS` duties of a direction, or if the dead band or
    a velocity is too great to be measured.
    """
    fastest = max((abs(each.velocity.value) for each in points), default=0.0)
    turning = [each for each in points if each.velocity.value * each.command > 0]
    turning = [each for each in turning if abs(each.velocity.value) >= MIN_TURNING * fastest]
    command = np.array([each.command for each in turning])
    speed = np.abs([each.velocity.value for each in turning])
    is_forward = command > 0
    for word, count in (("forward", is_forward.sum()), ("backward", (~is_forward).sum())):
        if count < MIN_POINTS:
            raise CalibrationError(
                f"the wheel turns {word} at {count} of the duties only. Check that nothing blocks it, and that its "
                "battery is charged",
                kind="too-few-points",
                direction=word,
            )
    deviation = np.hypot([each.velocity.deviation for each in turning], MODEL_ERROR * fastest)
    duty = np.abs(command)

    def compute_errors(parameters: Array) -> Array:
        return compute_speed(parameters, duty, is_forward) - speed

    start = np.array([0.1, speed[is_forward].max(), speed[~is_forward].max()])
    lower, upper = np.array([0.0, 0.0, 0.0]), np.array([MAX_DEAD_BAND, *(20 * start[1:])])
    fit = fit_nonlinear(
        lambda parameters: compute_errors(parameters) / deviation, start, lower, upper, least_variance=1.0
    )
    fit.require_below_limits(
        ("dead_band", "forward_rad_s", "backward_rad_s"),
        "The wheel turns at the greatest duties only. Charge the battery, and check that nothing blocks the wheel",
    )
    errors = compute_errors(fit.parameters)
    means = np.where(is_forward, speed[is_forward].mean(), speed[~is_forward].mean())
    explained = 1 - float(errors @ errors) / max(float(np.sum((speed - means) ** 2)), 1e-12)
    dead_band, forward, backward = fit.estimates
    rms = float(np.sqrt(np.mean(errors**2)))
    return VelocityCurve(dead_band, forward, backward, tuple(points), rms, explained)


def compute_speed(parameters: Array, duty: Array, is_forward: NDArray[np.bool_]) -> Array:
    """Return the speeds at duties without their sign, each (n,), in rad/s.

    parameters: the dead band, and the speeds at the duty 1 forward and backward in rad/s.
    """
    dead_band, forward, backward = parameters
    above = np.maximum(duty - dead_band, 0.0) / (1 - dead_band)
    speeds: Array = above * np.where(is_forward, forward, backward)
    return speeds
