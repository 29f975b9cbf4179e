"""Builds charts of the measured velocities of motors, the fitted curves, and those of the robot's file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robotcore.calibration.motors.measurement import MotorResult
from robotcore.calibration.motors.velocity_curve import VelocityCurve
from robotcore.canvas import RULE, SERIES
from robotcore.hardware.motor_model import MotorModel
from robotcore.view.chart import Chart, Series

HEADROOM = 1.1
"""The greatest velocity of a chart, as a share of the greatest one of its curves."""

DUTIES = np.linspace(-1.0, 1.0, 41)
"""The duties at which a curve is computed."""


def build_motor_charts(results: Sequence[MotorResult], models: Mapping[str, MotorModel]) -> list[Chart]:
    """Return a chart for each motor: its velocity over the duty.

    models: the models in the robot's file, by the name of the motor.
    """
    return [_build_chart(result, models.get(result.motor), number) for number, result in enumerate(results)]


def _build_chart(result: MotorResult, model: MotorModel | None, number: int) -> Chart:
    curve, colour = result.curve, SERIES[number % len(SERIES)]
    fitted = _compute_velocities(_build_model(curve))
    present = _compute_velocities(model) if model else np.empty(0)
    reach = HEADROOM * float(np.abs([*fitted, *present]).max())
    points = [(each.command, each.velocity.value) for each in curve.points]
    commands, velocities = ([point[axis] for point in points] for axis in (0, 1))
    series = [
        *([Series(DUTIES, present, RULE, 4.0, "the robot's file")] if model else []),
        Series(DUTIES, fitted, colour, label="fit"),
        Series(commands, velocities, colour, label="measured", has_dots=True),
    ]
    return Chart(
        f"{result.motor}, by {result.instrument}",
        series,
        "duty" if model else "share of the greatest velocity",
        "velocity in rad/s",
        x_range=(-1.0, 1.0),
        y_range=(-reach, reach),
    )


def _build_model(curve: VelocityCurve) -> MotorModel:
    full = {"forward_rad_s": curve.forward.value, "backward_rad_s": curve.backward.value}
    return MotorModel(dead_band=max(curve.dead_band.value, 0.0), **full)


def _compute_velocities(model: MotorModel) -> np.ndarray:
    return np.array([model.velocity(float(duty)) for duty in DUTIES])
