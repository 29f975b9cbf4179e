"""Compares the measured displacement of a robot with the path that its wheels have made."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robotcore.calibration.drive.geometry_fit import StraightDrive
from robotcore.calibration.least_squares import Array

MAX_STEPS, TOLERANCE_RAD = 50, 1e-9
"""The greatest number of steps of the fit of a turn, and the change in radians at which it ends."""


@dataclass(frozen=True)
class StraightPath:
    """The angles of the wheels during a straight drive, and the displacement that a reference has measured.

    A robot whose motors have different lags turns when it starts, and turns back when it stops. So the path is
    integrated over time. The total angles of the wheels do not show it.
    """

    left_rad: Array
    """The angles of the left wheels, (samples,) in radians."""
    right_rad: Array
    """The angles of the right wheels at the same times, (samples,) in radians."""
    forward_m: float
    """The measured displacement of the middle of the axle in the direction that the robot faced first, in metres."""
    left_m: float | None
    """The measured displacement to the left, in metres; None if only ``forward_m`` was measured."""
    deviation_m: float
    """The standard deviation of a measured distance, in metres."""

    def fit(self, turn_share: float) -> StraightDrive:
        """Return the drive with the way, and with the turn if the displacement to the left was measured.

        The wheels make the shape of the path. Its scale, and a further turn that grows with the way as that of wheels
        of different sizes, are those that lead to the measured place.

        turn_share: the angle in radians by which the robot turns if the right wheels turn by one radian more than the
            left ones. It is the wheel radius divided by the track.
        """
        left, right = (float(angles[-1] - angles[0]) for angles in (self.left_rad, self.right_rad))
        mean = (left + right) / 2
        if self.left_m is None:
            along = self._trace(turn_share, 0.0).real
            return StraightDrive(left, right, self.forward_m * mean / along if along else 0.0, self.deviation_m)
        moved, further = complex(self.forward_m, self.left_m), 0.0
        end = self._trace(turn_share, further)
        sign = 1 if (moved * end.conjugate()).real >= 0 else -1  # the wheels may seem to turn the other way
        for _ in range(MAX_STEPS):
            # The direction of the end of an arc is half the turn.
            change = 2 * cmath.phase(sign * moved * end.conjugate())
            further += change
            end = self._trace(turn_share, further)
            if abs(change) < TOLERANCE_RAD:
                break
        way = sign * abs(moved) * mean / abs(end) if end else 0.0
        return StraightDrive(left, right, way, self.deviation_m, (right - left) * turn_share + further)

    def _trace(self, turn_share: float, further_rad: float) -> complex:
        """Return the end of the path of wheels with a radius of 1 m, forward as the real part and left as the other."""
        rolled, turned = self._rolled, self._difference * turn_share
        if total := float(rolled.sum()):
            turned = turned + further_rad * rolled / total
        chords = rolled * np.sinc(turned / (2 * np.pi))  # of arcs between two samples
        return complex(np.sum(chords * np.exp(1j * (np.cumsum(turned) - turned / 2))))

    @cached_property
    def _rolled(self) -> Array:
        return np.diff((self.left_rad + self.right_rad) / 2)

    @cached_property
    def _difference(self) -> Array:
        return np.diff(self.right_rad - self.left_rad)
