"""Monitors of the sensors' plausibility: wheels that do not follow their commands, range readings that never change."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import copysign, degrees

from robotcore.errors import RangeFaultError, WheelFaultError
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Range, RangeSensor
from robotcore.safety.latch import Latch

MIN_RESPONSE = 0.25
"""The least share of the commanded angle that a wheel must turn. Lag, slip and a flat battery cost less."""

MIN_ANGLE_RAD = 1.0
"""A wheel is checked after this commanded angle, for at less the lag is too large a part of it."""

MIN_COUNTS = 4
"""The same for encoders so coarse that one count is more."""


class WheelTrackingCheck:
    """A rule that changes no command. It trips the latch if a wheel does not follow its command.

    A wheel is checked over a time in which it is driven in one direction: for ``patience`` seconds and at least
    `MIN_ANGLE_RAD`.

    commanded: returns the commanded angle of both wheels, in rad.
    turned: returns the angle of both wheels by their encoders, in rad.
    motors, encoders: the names of the left and the right one.
    patience: the least duration of a check, in seconds.
    count: the angle of one count of the coarser encoder, in rad.
    """

    cause = "wheel fault"

    def __init__(
        self,
        clock: Clock,
        latch: Latch,
        commanded: Callable[[], Wheels],
        turned: Callable[[], Wheels],
        motors: tuple[str, str],
        encoders: tuple[str, str],
        patience: float,
        count: float = 0.0,
    ) -> None:
        self._clock, self._latch, self._commanded, self._turned = clock, latch, commanded, turned
        enough = max(MIN_ANGLE_RAD, MIN_COUNTS * count)
        self._wheels = [_WheelCheck(*names, patience, enough) for names in zip(motors, encoders, strict=True)]

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        now, commanded, turned = self._clock.now(), self._commanded(), self._turned()
        judged = [wheel.judged(now, *each) for wheel, *each in zip(self._wheels, last, commanded, turned, strict=True)]
        if faults := [fault for fault in judged if fault]:
            self._latch.trip(WheelFaultError(faults))
        return asked


class _WheelCheck:
    """One wheel, and since when it has been driven the way it is."""

    def __init__(self, motor: str, encoder: str, patience: float, enough: float) -> None:
        self._motor, self._encoder, self._patience, self._enough = motor, encoder, patience, enough
        self._begin(0.0, 0.0, 0.0, 0.0)

    def judged(self, now: float, velocity: float, commanded: float, turned: float) -> str:
        """Return in words what is wrong, or nothing; all angles are from the same instant."""
        sense = copysign(1.0, velocity) if velocity else 0.0
        if sense == 0.0 or sense != self._sense:
            self._begin(now, sense, commanded, turned)
            return ""
        asked, done, passed = commanded - self._commanded, turned - self._turned, now - self._since
        if passed < self._patience or abs(asked) < self._enough:
            return ""
        self._begin(now, sense, commanded, turned)
        if done * sense >= MIN_RESPONSE * abs(asked):
            return ""
        action = f"{self._motor} was told to turn {asked:.1f} rad in {passed:.1f} s"
        return f"{action} and turned {round(done, 1) + 0.0} rad by {self._encoder}"  # no -0.0

    def _begin(self, now: float, sense: float, commanded: float, turned: float) -> None:
        self._since, self._sense, self._commanded, self._turned = now, sense, commanded, turned


SAME_DISTANCE_M = 0.001
"""Distances that differ by less are the same. No true one stays so for long: the robot moves 10 mm in a tick."""

MIN_TURN_RAD = 1.0
"""How far the robot must also have turned: along a wall, and in a corridor, a wide cone hears the same all the way."""


class StuckRangeCheck:
    """A rule that changes no command. It trips the latch if a range sensor returns one distance while the robot moves.

    The sensors are read only while the robot drives forward, as for the range guard. A distance outside of the
    sensor's range may stay the same for any time.

    pose: returns the pose by the encoders. Without encoders a stalled robot would look like a stuck sensor.
    patience: how far the robot must have driven meanwhile, in metres; it must have turned by `MIN_TURN_RAD` as well.
    """

    cause = "range fault"

    def __init__(self, latch: Latch, sensors: Iterable[RangeSensor], pose: Callable[[], Pose], patience: float) -> None:
        self._latch, self._pose = latch, pose
        self._sensors = [_RangeHistory(sensor, patience) for sensor in sensors]

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        if asked.left + asked.right > 0:
            pose = self._pose()
            if faults := [fault for fault in (sensor.judged(pose) for sensor in self._sensors) if fault]:
                self._latch.trip(RangeFaultError(faults))
        return asked


class _RangeHistory:
    """The last reading of one sensor, and how far the robot has moved since the reading changed."""

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
        if self._driven < self._patience or self._turned < MIN_TURN_RAD:
            return ""
        gone = f"drove {self._driven:.2f} m and turned {degrees(self._turned):.0f}°"
        return f"{self._sensor.name} told the same {self._distance:.2f} m while the wheels {gone}"

    def _repeats(self, distance: float) -> bool:
        is_measured = self._sensor.min_range < distance < self._sensor.max_range
        return is_measured and abs(distance - self._distance) < SAME_DISTANCE_M

    def _begin(self, distance: float, pose: Pose) -> None:
        self._distance, self._at = distance, pose
        self._driven = self._turned = 0.0
