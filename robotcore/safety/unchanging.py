"""Whether range sensors tell anything new where the robot goes: one that does not is stuck, or the robot is."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import degrees

from robotcore.errors import RangeFaultError
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.hal.devices import Range, RangeSensor
from robotcore.safety.latch import Latch

SAME_M = 0.001
"""Distances that differ by less are the same. No true one stays so for long: the robot moves 10 mm in a tick."""

TURNED_RAD = 1.0
"""How far the robot must also have turned: along a wall, and in a corridor, a wide cone hears the same all the way."""


class RangesChange:
    """A rule that changes no command, and trips the latch where a range sensor tells the same wherever the robot goes.

    ``pose`` is where the wheels have taken the robot, by their encoders: a robot that only believes to move hears the
    same rightly. ``patience`` is how far it must have driven meanwhile, in metres, and it must have turned as well.
    The sensors are read only when the robot would move forward, as for the range guard. Nothing in range, and all that
    is nearer than a sensor can tell, may be the same for ever.
    """

    cause = "range fault"

    def __init__(self, latch: Latch, sensors: Iterable[RangeSensor], pose: Callable[[], Pose], patience: float) -> None:
        self._latch, self._pose = latch, pose
        self._sensors = [_Told(sensor, patience) for sensor in sensors]

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        if asked.left + asked.right > 0:
            pose = self._pose()
            if faults := [fault for fault in (sensor.judged(pose) for sensor in self._sensors) if fault]:
                self._latch.trip(RangeFaultError(faults))
        return asked


class _Told:
    """What one sensor told last, since when it is the same, and how far the robot has gone from reading to reading."""

    def __init__(self, sensor: RangeSensor, patience: float) -> None:
        self._sensor, self._patience = sensor, patience
        self._last: Range | None = None
        self._at = Pose(0.0, 0.0, 0.0)
        self._distance = self._driven = self._turned = 0.0

    def judged(self, pose: Pose) -> str:
        """Return in words what is wrong, or nothing."""
        reading = self._sensor.read()
        if self._last and reading.sequence == self._last.sequence:
            return ""
        self._last = reading
        if not self._repeats(reading.distance):
            self._begin(reading.distance, pose)
            return ""
        self._driven += pose.distance_to(self._at.x, self._at.y)
        self._turned += abs(wrap_angle(pose.heading - self._at.heading))
        self._at = pose
        if self._driven < self._patience or self._turned < TURNED_RAD:
            return ""
        gone = f"drove {self._driven:.2f} m and turned {degrees(self._turned):.0f}°"
        return f"{self._sensor.name} told the same {self._distance:.2f} m while the wheels {gone}"

    def _repeats(self, distance: float) -> bool:
        is_measured = self._sensor.min_range < distance < self._sensor.max_range
        return is_measured and abs(distance - self._distance) < SAME_M

    def _begin(self, distance: float, pose: Pose) -> None:
        self._distance, self._at = distance, pose
        self._driven = self._turned = 0.0
