from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.calibration.drive.room_profile import fit_full_turn
from robotcore.calibration.least_squares import Array
from robotcore.errors import CalibrationError
from tests.texts import Raises


def look_around(turns: float, full_rad: float, *, noise: float = 0.0) -> tuple[Array, Array]:
    """Return the angles by the wheels and the distances of a sensor in a room, near one of its corners.

    full_rad: the angle by the wheels after a full turn.
    """
    true = np.arange(0.001, turns * math.tau, 0.06)
    x, y = np.cos(true), np.sin(true)
    walls = [np.where(x > 0, 1.5, -0.6) / x, np.where(y > 0, 0.8, -1.9) / y]
    distances = np.minimum(*walls) + np.random.default_rng(1).normal(0, noise, len(true))
    return true / math.tau * full_rad, np.where(distances > 1.6, np.inf, distances)


@pytest.mark.parametrize("full", [0.85, 1.0, 1.07, 1.2])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_full_turn_is_found_by_the_repeated_distances(full: float, sign: int) -> None:
    angles, distances = look_around(5, full * math.tau, noise=0.005)
    found = fit_full_turn(sign * angles, distances)
    assert found.value == pytest.approx(full * math.tau, rel=0.003)
    assert found.deviation < 0.004 * found.value


@pytest.mark.parametrize(
    "turns, distances, kind", [(1.5, None, "too-few-turns"), (4, np.inf, "no-wall"), (4, 0.7, "no-wall")]
)
def test_a_turn_that_cannot_be_found_is_an_error(
    turns: float, distances: float | None, kind: str, raises: Raises
) -> None:
    angles, measured = look_around(turns, math.tau)
    if distances is not None:
        measured = distances + np.random.default_rng(2).normal(0, 0.002, len(angles))
    with raises(CalibrationError, kind):
        fit_full_turn(angles, measured)
