"""The rules for a wheel command, and the interventions that record a change. A rule scales both wheels together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from robotcore.geometry import DifferentialGeometry, Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.devices import RangeSensor

STOPPED = Wheels(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Intervention:
    """The stage changed a command: when, by which rule, and what became of it."""

    time: float
    cause: str
    asked: Wheels
    sent: Wheels


class Rule(Protocol):
    """Something that may lessen a command. ``last`` is the command that was sent before it."""

    cause: str

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels: ...


class VelocityLimit:
    """No wheel turns faster than ``limit`` rad/s; both are scaled alike."""

    cause = "velocity limit"

    def __init__(self, limit: float) -> None:
        self._limit = limit

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        left, right = asked
        fastest = max(abs(left), abs(right))
        if fastest <= self._limit:
            return asked
        scale = self._limit / fastest
        return Wheels(left * scale, right * scale)


class AccelerationLimit:
    """No wheel changes its velocity by more than ``change`` rad/s in a tick; both changes are scaled alike."""

    cause = "acceleration limit"

    def __init__(self, change: float) -> None:
        self._change = change

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        left, right = asked.left - last.left, asked.right - last.right
        largest = max(abs(left), abs(right))
        if largest <= self._change:
            return asked
        scale = self._change / largest
        return Wheels(last.left + left * scale, last.right + right * scale)


class RangeGuard:
    """Takes forward motion away where something is nearer than the robot could stop; turning stays.

    ``distance`` returns what may be left ahead, in metres, for a robot that drives at the given speed since its newest
    reading, m/s. It is asked only when the robot would move forward.
    """

    cause = "range guard"

    def __init__(
        self,
        geometry: DifferentialGeometry,
        distance: Callable[[float], float],
        stop_distance: float,
        deceleration: float,
    ) -> None:
        self._geometry = geometry
        self._distance = distance
        self._stop_distance = stop_distance
        self._deceleration = deceleration

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        forward = (asked.left + asked.right) / 2
        if forward <= 0:
            return asked
        speed = forward * self._geometry.wheel_radius
        fastest = max(speed, (last.left + last.right) / 2 * self._geometry.wheel_radius)
        if self._distance(fastest) > stopping_distance(speed, self._stop_distance, self._deceleration):
            return asked
        return Wheels(asked.left - forward, asked.right - forward)


class DistanceAhead:
    """What range sensors leave to drive: the nearest reading, less the way that may have been driven since.

    That is the highest speed that was asked about since the reading came, times its age.
    """

    def __init__(self, clock: Clock, sensors: Sequence[RangeSensor]) -> None:
        self._clock = clock
        self._left = [_ClearanceAhead(sensor) for sensor in sensors]

    def __call__(self, speed: float) -> float:
        now = self._clock.now()
        return min([left.at(now, speed) for left in self._left])


class _ClearanceAhead:
    """What one sensor leaves to drive."""

    def __init__(self, sensor: RangeSensor) -> None:
        self._sensor = sensor
        self._sequence: int | None = None
        self._fastest = 0.0

    def at(self, now: float, speed: float) -> float:
        sample = self._sensor.read()
        is_new = sample.sequence != self._sequence
        self._sequence = sample.sequence
        self._fastest = speed if is_new else max(speed, self._fastest)
        return sample.distance - self._fastest * max(0.0, now - sample.time)


def stopping_distance(speed: float, stop_distance: float, deceleration: float) -> float:
    """Return where the range guard acts at ``speed`` m/s: stop_distance + v²/2a, in metres."""
    return stop_distance + speed * speed / (2 * deceleration)
