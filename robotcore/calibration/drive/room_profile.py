"""Finds by how much a robot turns, from the distances that it measures around it in several turns on the spot."""

from __future__ import annotations

import math

import numpy as np

from robotcore.calibration.least_squares import Array, Estimate
from robotcore.errors import CalibrationError

BINS = 90
"""The number of directions in which the distances of all turns are compared."""

SEARCH = 0.25
"""The true turn is searched within this share of the turn by the wheels."""

MIN_CONTRAST = 4.0
"""The differences of the distances in one direction must be this many times smaller than those around the robot."""

MIN_TURNS = 2.0
FAR = 1.5
"""Nothing in range counts as a distance of this many times the greatest measured one."""


def fit_full_turn(angles: Array, distances: Array) -> Estimate:
    """Return the angle by the wheels after which the robot has made one full turn, in radians.

    After a full turn, a sensor measures the same distances again. So the angle is the period of the distances. It is
    the one for which the distances in each direction differ the least (phase dispersion minimisation, R. F.
    Stellingwerf, Astrophysical Journal 224 (1978), 953).

    angles: the angle of the robot by its wheels at each sample, (samples,) in radians, growing or falling.
    distances: the measured distances, (samples,) in metres, ``inf`` if nothing is in range.

    Raises CalibrationError if the robot has turned less than twice, or if the surroundings have no shape.
    """
    turns = abs(float(angles[-1] - angles[0])) / math.tau
    if turns < MIN_TURNS:
        text = f"the robot has turned {turns:.1f} times by its wheels, and two turns are needed. Give more --turns"
        raise CalibrationError(text, kind="too-few-turns")
    finite = distances[np.isfinite(distances)]
    if not len(finite):
        raise CalibrationError(_describe("nothing is in range"), kind="no-wall")
    values = np.minimum(distances, FAR * float(finite.max()))
    coarse = np.linspace(1 - SEARCH, 1 + SEARCH, round(60 * turns) + 1) * math.tau
    best = _find_least(coarse, angles, values)
    step = float(coarse[1] - coarse[0])
    fine = np.linspace(best - step, best + step, 81)
    best = _find_least(fine, angles, values)
    spread = float(np.var(values))
    if spread < MIN_CONTRAST * _disperse(best, angles, values):
        raise CalibrationError(_describe("the distances do not repeat"), kind="no-wall")
    return Estimate(best, math.tau / BINS / turns)


def _find_least(periods: Array, angles: Array, values: Array) -> float:
    return float(periods[int(np.argmin([_disperse(float(each), angles, values) for each in periods]))])


def _disperse(period: float, angles: Array, values: Array) -> float:
    """Return the mean variance of the values in a direction if a full turn is ``period``."""
    number = (np.mod(angles, period) / period * BINS).astype(int) % BINS
    counts = np.maximum(np.bincount(number, minlength=BINS), 1)
    mean = np.bincount(number, values, BINS) / counts
    return float(np.mean((values - mean[number]) ** 2))


def _describe(problem: str) -> str:
    return f"{problem} around the robot. Put it within 1 m of a wall, where nothing moves"
