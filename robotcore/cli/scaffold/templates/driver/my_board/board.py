"""The board. This one is made up: put the calls of your board's library in its place."""

import math

from robotcore.geometry import DifferentialGeometry, Pose, Wheels
from robotcore.hal.clock import Clock, SteppedClock

GEOMETRY = DifferentialGeometry(wheel_radius=0.0325, track=0.155)
WALL_M = 1.5
"""How far ahead of the start there is a wall."""

FULL_V = 7.8


class Board:
    """Two wheels that follow their commands, and a wall ahead.

    The app and what polls the sensors call it from threads of their own: where the library takes one call at a time,
    put a lock around it here.
    """

    def __init__(self) -> None:
        self._velocities = {"left": 0.0, "right": 0.0}
        self._angles = {"left": 0.0, "right": 0.0}
        self._pose = Pose(0.0, 0.0, 0.0)

    def clock(self, rate_hz: float) -> Clock:
        """Return the time that the robot goes by; on a real board that is `MonotonicClock()`."""
        clock = SteppedClock(rate_hz, lambda steps: self._pass(steps * clock.step))
        return clock

    def turn(self, wheel: str, rad_s: float) -> None:
        """Turn the left or the right wheel; positive drives the robot forward."""
        self._velocities[wheel] = rad_s

    def angle(self, wheel: str) -> float:
        """Return how far a wheel has turned, rad."""
        return self._angles[wheel]

    def distance(self) -> float:
        """Return the way from the axle to the wall, m; inf where none is ahead."""
        ahead = math.cos(self._pose.heading)
        return (WALL_M - self._pose.x) / ahead if ahead > 0 else math.inf

    def voltage(self) -> float:
        """Return the battery's voltage, V."""
        return FULL_V

    def disconnect(self) -> None:
        """Let the board go, its wheels at rest."""
        self._velocities = dict.fromkeys(self._velocities, 0.0)

    def _pass(self, seconds: float) -> None:
        left, right = (velocity * seconds for velocity in self._velocities.values())
        self._angles["left"] += left
        self._angles["right"] += right
        self._pose = self._pose.advanced(*GEOMETRY.to_twist(Wheels(left, right)))
