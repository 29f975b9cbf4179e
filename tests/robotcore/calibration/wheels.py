"""A simulated wheel that follows steps of a command with a delay and a lag."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robotcore.calibration.excitation import CommandStep
from robotcore.calibration.least_squares import Array
from robotcore.hardware.motor_model import MotorModel

STEP_S = 0.0005


def list_steps(levels: Sequence[float], step_s: float = 0.8, rest_s: float = 0.3) -> list[CommandStep]:
    """Return a rest, and for each level a step forward and a step backward with a rest after each."""
    steps, time = [CommandStep(0.0, rest_s, 0.0)], rest_s
    for command in (sign * level for level in levels for sign in (1, -1)):
        steps += [CommandStep(time, time + step_s, command), CommandStep(time + step_s, time + step_s + rest_s, 0.0)]
        time += step_s + rest_s
    return steps


def turn_wheel(
    steps: Sequence[CommandStep],
    model: MotorModel,
    lag_s: float,
    delay_s: float = 0.0,
    resolution_rad: float = 0.0,
    period_s: float = 0.01,
) -> tuple[Array, Array]:
    """Return the times and the angles of samples of the wheel, (samples,) in seconds and radians.

    resolution_rad: the angle of a count of the encoder; 0 for exact angles.
    """
    times = np.arange(0.0, steps[-1].end, STEP_S)
    velocity = angle = 0.0
    target, angles, share = 0.0, [], -math.expm1(-STEP_S / lag_s) if lag_s else 1.0
    starts = iter([*steps, None])
    coming = next(starts)
    for time in times:
        while coming and time >= coming.start + delay_s - 1e-9:
            target, coming = model.velocity(coming.command), next(starts)
        angles.append(angle)
        # exact for a first-order lag
        moved = target * STEP_S + (velocity - target) * lag_s * share
        velocity += (target - velocity) * share
        angle += moved
    every = round(period_s / STEP_S)
    found = np.array(angles)[::every]
    return times[::every], np.round(found / resolution_rad) * resolution_rad if resolution_rad else found
