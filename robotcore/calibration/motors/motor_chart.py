"""Draws the measured velocities of motors, the fitted curves, and those of the robot's file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robotcore.calibration.chart import Chart, Point
from robotcore.calibration.motors.measurement import MotorResult
from robotcore.calibration.motors.velocity_curve import VelocityCurve
from robotcore.canvas import FADED, INK, PAPER, RULE, SERIES, Canvas
from robotcore.hardware.motor_model import MotorModel
from robotcore.optics import Image

WIDTH, HEIGHT = 560, 420
"""The size of the chart of a motor, in pixels."""

COLUMNS, TOP, EDGE = 2, 70, 20
HEADROOM = 1.1
STEPS = 41
"""The number of points of a curve."""


def draw_motors(results: Sequence[MotorResult], models: Mapping[str, MotorModel], heading: str) -> Image:
    """Return a picture with a chart for each motor: its velocity over the duty.

    models: the models in the robot's file, by the name of the motor.
    """
    rows = (len(results) + COLUMNS - 1) // COLUMNS
    canvas = Canvas(2 * EDGE + COLUMNS * WIDTH, TOP + rows * HEIGHT + EDGE, PAPER)
    canvas.write_text((EDGE + 20, 34), heading, INK, 18, bold=True)
    canvas.write_text((EDGE + 20, 56), "dots: measured. coloured: fitted. grey: the robot's file", FADED, 11)
    for number, result in enumerate(results):
        place = (EDGE + number % COLUMNS * WIDTH, TOP + number // COLUMNS * HEIGHT)
        _draw_motor(canvas, place, result, models.get(result.motor), number)
    return canvas.render()


def _draw_motor(canvas: Canvas, place: Point, result: MotorResult, model: MotorModel | None, number: int) -> None:
    curve, colour = result.curve, SERIES[number % len(SERIES)]
    present = [(x, model.velocity(x)) for x in _spread()] if model else []
    fitted = [(x, compute_velocity(curve, x)) for x in _spread()]
    reach = HEADROOM * max(abs(y) for _, y in (*present, *fitted))
    chart = Chart(canvas, place, (WIDTH, HEIGHT), (-1.0, 1.0), (-reach, reach))
    command = "duty" if model else "share of the greatest velocity"
    chart.draw_axes(f"{result.motor}, by {result.instrument}", command, "velocity in rad/s")
    if present:
        chart.draw_curve(present, RULE, 4)
    chart.draw_curve(fitted, colour)
    chart.draw_points(((each.command, each.velocity.value) for each in curve.points), colour)


def _spread() -> list[float]:
    return [float(each) for each in np.linspace(-1, 1, STEPS)]


def compute_velocity(curve: VelocityCurve, command: float) -> float:
    """Return the velocity of the fitted curve at a duty, in rad/s."""
    full = {"forward_rad_s": curve.forward.value, "backward_rad_s": curve.backward.value}
    return MotorModel(dead_band=max(curve.dead_band.value, 0.0), **full).velocity(command)
