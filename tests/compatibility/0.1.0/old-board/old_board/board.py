"""The connection to the board. This board is invented. Replace its methods by calls of your board's library."""

import math

from robotcore.geometry import DifferentialGeometry, Pose, Wheels
from robotcore.hal.clock import Clock, SteppedClock

GEOMETRY = DifferentialGeometry(wheel_radius=0.0325, track=0.155)
WALL_M = 1.5
"""The distance from the start to the wall."""

FULL_V = 7.8


class Board:
    """A simulated board with two wheels that follow their commands, and a wall ahead. The tests measure its ``pose``.

    Several threads call it, because commands are sent and sensors are polled while the app runs. If your library
    allows only one call at a time, add a lock here.
    """

    def __init__(self) -> None:
        self._velocities = {"left": 0.0, "right": 0.0}
        self._angles = {"left": 0.0, "right": 0.0}
        self.pose = Pose(0.0, 0.0, 0.0)

    def clock(self, rate_hz: float) -> Clock:
        """Return the robot's clock. For a real board, return `MonotonicClock()`."""
        clock = SteppedClock(rate_hz, lambda steps: self._advance(steps * clock.step))
        return clock

    def turn(self, wheel: str, rad_s: float) -> None:
        """Turn the left or the right wheel. A positive velocity drives the robot forward."""
        self._velocities[wheel] = rad_s

    def angle(self, wheel: str) -> float:
        """Return the angle of a wheel in rad."""
        return self._angles[wheel]

    def distance(self) -> float:
        """Return the distance from the axle to the wall in m, or inf if the wall is behind the robot."""
        ahead = math.cos(self.pose.heading)
        return (WALL_M - self.pose.x) / ahead if ahead > 0 else math.inf

    def voltage(self) -> float:
        """Return the battery's voltage in V."""
        return FULL_V

    def disconnect(self) -> None:
        """Stop the wheels, and close the connection."""
        self._velocities = dict.fromkeys(self._velocities, 0.0)

    def _advance(self, seconds: float) -> None:
        left, right = (velocity * seconds for velocity in self._velocities.values())
        self._angles["left"] += left
        self._angles["right"] += right
        self.pose = self.pose.advance(*GEOMETRY.to_twist(Wheels(left, right)))
