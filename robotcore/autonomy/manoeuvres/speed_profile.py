"""The speed of a manoeuvre in each tick: a trapezoid that ends at a position."""

from __future__ import annotations

import math
from dataclasses import dataclass

LAG_S = 0.05
"""The assumed time constant with which wheels follow their commands, in seconds."""

GAIN = 4.0
"""The speed near the end of a manoeuvre, in m/s for each metre that remains."""

SLOWEST_M_S = 0.01
"""The speed of a wheel below which a manoeuvre does not slow down before its end, in m/s. Motors may stall below it."""


@dataclass
class SpeedProfile:
    """Computes the speed for each tick. All values are those of a distance in m, or of an angle in rad.

    The speed rises at the constant acceleration, stays at ``top``, and falls so that the robot stands at the end of its
    way. Each tick computes the speed anew from the way that remains, so errors of the motion have no lasting effect.
    """

    top: float
    """The greatest speed, per second."""
    acceleration: float
    """The acceleration, per second squared."""
    slowest: float
    """The least speed before the end, per second."""

    def divide(self, divisor: float) -> SpeedProfile:
        """Return a profile whose values are those of this one divided by a number."""
        return SpeedProfile(self.top / divisor, self.acceleration / divisor, self.slowest / divisor)

    def limit_to(self, ratio: float, greatest: float) -> SpeedProfile:
        """Return the profile for a path with bends.

        ratio: half of the distance between the wheels, divided by the radius of the sharpest bend.
        greatest: the greatest speed of a wheel, in m/s.
        """
        outer = 1 + ratio
        return SpeedProfile(min(self.top, greatest / outer), self.acceleration / outer, self.slowest / outer)

    def compute_speed(self, remaining: float, last: float, period: float) -> float:
        """Return the speed for the next tick. It has the sign of ``remaining``.

        remaining: the way that remains, after the wheels have come to rest.
        last: the speed in the last tick.
        period: the duration of a tick in seconds.
        """
        sign, way = math.copysign(1.0, remaining), abs(remaining)
        rising = max(0.0, last * sign) + self.acceleration * period
        falling = max(self._compute_braking_speed(way, period), self.slowest)
        return sign * min(self.top, rising, falling, way / period)

    def _compute_braking_speed(self, way: float, period: float) -> float:
        """Return the speed from which the robot can brake on a way, with a soft end.

        The speed falls at the constant acceleration a. From the way a/GAIN² on, it is proportional to the way.
        """
        soft = self.acceleration / GAIN**2
        if way <= soft:
            return GAIN * way
        half_step = self.acceleration * period / 2
        return math.sqrt(half_step**2 + 2 * self.acceleration * (way - soft / 2)) - half_step


class CoastingEstimator:
    """Estimates the way that the robot still moves if its command becomes zero now.

    The way is the lag of the wheels times their velocity, which follows the commands with this lag.

    lag: the time constant in seconds; 0 for a way that is not measured but computed from the commands.
    """

    def __init__(self, lag: float) -> None:
        self._lag, self._speed = lag, 0.0

    @property
    def way(self) -> float:
        """The way in m or in rad, with the sign of the motion."""
        return self._lag * self._speed

    def add_command(self, speed: float, period: float) -> None:
        """Add the speed that was sent for a tick of ``period`` seconds."""
        if self._lag:
            self._speed += (speed - self._speed) * -math.expm1(-period / self._lag)
