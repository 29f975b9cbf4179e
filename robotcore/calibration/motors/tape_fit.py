"""Fits both motors of a drive to the displacements of a robot, which a person has measured with a tape."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robotcore.calibration.excitation_runs import Displacement
from robotcore.calibration.least_squares import Array, Estimate, fit_nonlinear
from robotcore.calibration.motors.response import compute_step_response
from robotcore.calibration.motors.velocity_curve import MAX_DEAD_BAND, CurvePoint, VelocityCurve, compute_speed
from robotcore.errors import CalibrationError
from robotcore.geometry import DifferentialGeometry

TAPE_ERROR_M = 0.003
"""The standard deviation of a distance by a tape measure, in metres."""

ALIGNMENT_RAD = math.radians(1.0)
"""The standard deviation of the direction in which a person puts the robot, in radians."""

LAG_ERROR_S = 0.05
"""The standard deviation of the lag in the robot's file, in seconds. Displacements show only the difference of both."""

LAG_DIFFERENCE_S = 0.015
"""The standard deviation of the difference between the lags of two motors, in seconds. They are of one type."""

MAX_DEVIATIONS = 8.0
"""The greatest root mean square of the displacements' errors, in standard deviations of a measured displacement."""

MIN_WAY_M = 0.02
"""A robot that has moved less than this has not moved, in metres."""

MAX_LAG_S = 1.0
GRID_S = 0.005
"""The time step of the computed path, in seconds."""

COAST_LAGS = 8
"""The path ends this many lags after the last command."""


class TapeDrive(NamedTuple):
    """A drive with one command for all wheels, and how far the robot has moved."""

    command: float
    """The duty, or the share of the full command, from -1 to 1."""
    duration_s: float
    moved: Displacement


class PresentMotor(NamedTuple):
    """The values of a motor in the robot's file, with which the fit begins."""

    dead_band: float
    forward_rad_s: float
    backward_rad_s: float
    lag_s: float


@dataclass(frozen=True)
class _Model:
    """Computes the displacements of a robot from the parameters of its two wheels: 4 of each, or 4 of both."""

    drives: Sequence[TapeDrive]
    geometry: DifferentialGeometry
    has_one_motor: bool

    def predict(self, parameters: Array) -> Array:
        """Return the displacement of each drive forward and to the left, (drives, 2) in metres."""
        wheels = parameters.reshape(-1, 4)
        left, right = (wheels[0], wheels[0]) if self.has_one_motor else (wheels[0], wheels[1])
        return np.array([self._drive(each, left, right) for each in self.drives])

    def _drive(self, drive: TapeDrive, left: Array, right: Array) -> tuple[float, float]:
        end = drive.duration_s + COAST_LAGS * max(left[3], right[3])
        times = np.linspace(0.0, end, math.ceil(end / GRID_S) + 1)
        ways = [self._roll(drive, wheel, times) for wheel in (left, right)]
        heading = (ways[1] - ways[0]) / self.geometry.track
        step = np.diff((ways[0] + ways[1]) / 2)
        middle = (heading[1:] + heading[:-1]) / 2
        return float(step @ np.cos(middle)), float(step @ np.sin(middle))

    def _roll(self, drive: TapeDrive, wheel: Array, times: Array) -> Array:
        speed = compute_speed(wheel[:3], np.array([abs(drive.command)]), np.array([drive.command > 0]))[0]
        after = compute_step_response(times - drive.duration_s, wheel[3])
        full_m_s = math.copysign(speed, drive.command) * self.geometry.wheel_radius
        way: Array = full_m_s * (compute_step_response(times, wheel[3]) - after)
        return way


def fit_tape(
    drives: Sequence[TapeDrive], geometry: DifferentialGeometry, present: Sequence[PresentMotor]
) -> list[VelocityCurve]:
    """Return the curve of each motor.

    The lags are fitted too, because a robot whose motors have different lags turns when it starts. But displacements
    show only their difference, and not well. So the lags of the file and equal lags are preferred.

    drives: drives at two commands or more, forward and backward.
    geometry: the wheel radius and the track, which must be right.
    present: the values of the left and the right motor in the robot's file, or of the one motor of both sides.

    Raises CalibrationError if the robot has not moved in a drive, if a value of a motor is at the limit of the fit, or
    if the displacements are not those of such motors.
    """
    measured = np.array([each.moved for each in drives])
    if (still := np.abs(measured[:, 0]).min()) < MIN_WAY_M:
        raise CalibrationError(
            f"the robot has moved by {still:.3f} m only. Check that nothing blocks it, and its motors with "
            "robotcore test-devices",
            kind="no-motion",
        )
    model = _Model(drives, geometry, len(present) == 1)
    deviation = np.column_stack(
        [np.full(len(drives), TAPE_ERROR_M), np.hypot(TAPE_ERROR_M, ALIGNMENT_RAD * measured[:, 0])]
    )
    start = np.array(present, float).ravel()
    lags = start[3::4]

    def compute_errors(parameters: Array) -> Array:
        errors = ((model.predict(parameters) - measured) / deviation).ravel()
        found = parameters[3::4]
        return np.concatenate([errors, (found - lags) / LAG_ERROR_S, np.diff(found) / LAG_DIFFERENCE_S])

    lower = np.tile([0.0, 0.0, 0.0, 1e-3], len(present))
    upper = np.tile([MAX_DEAD_BAND, *(10 * start[1:3]), MAX_LAG_S], len(present))
    fit = fit_nonlinear(compute_errors, start, lower, upper, least_variance=1.0)
    fit.require_below_limits(
        [f"{key} of the {side} motor" for side in ("left", "right")[: len(present)] for key in PresentMotor._fields],
        "Measure the distances again, and check the wheel radius and the track in the robot's file with robotcore "
        "calibrate drive",
    )
    ratios = measured[:, 0] / model.predict(fit.parameters)[:, 0]
    errors = model.predict(fit.parameters) - measured
    if (deviations := math.sqrt(float(np.mean((errors / deviation) ** 2)))) > MAX_DEVIATIONS:
        raise CalibrationError(
            f"the distances differ from those of the fit by {math.sqrt(float(np.mean(errors**2))):.3f} m. Measure them "
            f"again, check that the wheels do not slip, and that lag_s in the robot's file is about right: "
            f"{', '.join(f'{each:g}' for each in lags)} s",
            kind="poor-fit",
            deviations=deviations,
        )
    explained = 1 - float(np.sum(errors**2)) / float(np.sum(measured**2))
    curves = []
    for wheel, estimates in zip(fit.parameters.reshape(-1, 4), _group(fit.estimates), strict=True):
        points = _list_points(drives, wheel[:3], ratios)
        residuals = np.array([each.velocity.value for each in points]) * (1 - 1 / ratios)
        dead_band, forward, backward, _ = estimates
        rms = float(np.sqrt(np.mean(residuals**2)))
        curves.append(VelocityCurve(dead_band, forward, backward, points, rms, explained))
    return curves


def _group(estimates: Sequence[Estimate]) -> list[list[Estimate]]:
    return [list(estimates[first : first + 4]) for first in range(0, len(estimates), 4)]


def _list_points(drives: Sequence[TapeDrive], wheel: Array, ratios: Array) -> tuple[CurvePoint, ...]:
    """Return the velocity of a wheel in each drive: the fitted one, times the measured way by the fitted way."""
    commands = np.array([each.command for each in drives])
    speeds = np.copysign(compute_speed(wheel, np.abs(commands), commands > 0) * ratios, commands)
    return tuple(
        CurvePoint(each.command, Estimate(float(speed), abs(float(speed) * TAPE_ERROR_M / each.moved.forward_m)))
        for each, speed in zip(drives, speeds, strict=True)
    )
