"""The range guard: stops forward motion near an obstacle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from robotcore.description.devices import AHEAD_RAD
from robotcore.geometry import DifferentialGeometry, Twist, Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.device import Sample
from robotcore.safety.sensor_ahead import SensorAhead
from robotcore.safety.velocity_limits import STOPPED


@dataclass(eq=False)
class RangeGuard:
    """A rule that removes forward motion near an obstacle. The robot can still turn and drive backward.

    A robot that cannot turn on the spot stops.
    """

    cause: ClassVar = "range guard"

    geometry: DifferentialGeometry = field(repr=False)
    """The geometry that converts wheel velocities to a speed."""
    distance: Callable[[float], float] = field(repr=False)
    """Returns the free distance ahead in metres, for the robot's speed in m/s. It is called only for forward motion."""
    stop_distance: float
    """The least distance to an obstacle after the stop, in metres."""
    deceleration: float
    """How fast the robot brakes, in m/s²."""
    can_turn_on_spot: bool = True
    """Whether the robot can turn on the spot."""

    def __call__(self, command: Wheels, last: Wheels) -> Wheels:
        forward = (command.left + command.right) / 2
        if forward <= 0:
            return command
        speed = forward * self.geometry.wheel_radius
        fastest = max(speed, (last.left + last.right) / 2 * self.geometry.wheel_radius)
        if self.distance(fastest) > compute_stopping_distance(speed, self.stop_distance, self.deceleration):
            return command
        return Wheels(command.left - forward, command.right - forward) if self.can_turn_on_spot else STOPPED


class DistanceAhead:
    """Computes the free distance ahead, in metres, from the readings of all sensors that look ahead.

    It subtracts from each reading the distance that the robot may have driven since then: the age of the reading times
    the highest speed since the reading.

    A sensor that a servo has turned aside is not read. If servos have turned all sensors aside, the robot drives only
    as far as a sensor has seen straight ahead. After a turn by more than `AHEAD_RAD`, it has seen nothing.

    read_motion: a function that returns how far the commands have moved the robot since the start: the length of its
        path in metres, and its turn in radians.
    """

    def __init__(self, clock: Clock, sensors: Sequence[SensorAhead], read_motion: Callable[[], Twist]) -> None:
        self._clock, self._read_motion = clock, read_motion
        self._clearances = [_ClearanceAhead(sensor) for sensor in sensors]
        self._seen, self._seen_at = 0.0, Twist(0.0, 0.0)

    def __call__(self, speed: float) -> float:
        now = self._clock.now()
        distances = [each for each in (clearance.at(now, speed) for clearance in self._clearances) if each is not None]
        if not distances:
            return self._estimate()
        distance = min(distances)
        if ranges := [each.max_range for each in self._clearances if each.is_straight]:
            self._seen, self._seen_at = min(distance, *ranges), self._read_motion()
        return distance

    def _estimate(self) -> float:
        """Return the distance that a sensor has seen straight ahead, without the distance that was driven since."""
        moved, seen_at = self._read_motion(), self._seen_at
        is_turned = abs(moved.angular - seen_at.angular) > AHEAD_RAD
        return 0.0 if is_turned else self._seen - max(0.0, moved.linear - seen_at.linear)


class _ClearanceAhead:
    def __init__(self, sensor: SensorAhead) -> None:
        self._sensor = sensor
        self._sequence: int | None = None
        self._fastest = 0.0
        self.max_range: float = getattr(sensor.device, "max_range", math.inf)
        self.is_straight = False

    def at(self, now: float, speed: float) -> float | None:
        """Return the free distance ahead in metres; 0 if it is not a number, and None if the sensor looks aside.

        Afterwards, ``is_straight`` is whether a servo had turned the sensor straight ahead.
        """
        self.is_straight = False
        if not self._sensor.looks_ahead(now):
            return None
        sample: Sample = self._sensor.device.read()
        is_new = sample.sequence != self._sequence
        self._sequence = sample.sequence
        self._fastest = speed if is_new else max(speed, self._fastest)
        if not self._sensor.looks_ahead(sample.time):
            return None
        self.is_straight = not self._sensor.is_fixed and self._sensor.looks_straight_ahead(sample.time)
        distance = self._sensor.measure(sample) - self._fastest * max(0.0, now - sample.time)
        return 0.0 if math.isnan(distance) else distance


def compute_stopping_distance(speed: float, stop_distance: float, deceleration: float) -> float:
    """Return the distance at which the range guard removes forward motion, in metres: stop_distance + v²/2a.

    speed: the robot's speed v, in m/s.
    stop_distance: the least distance to an obstacle after the stop, in metres.
    deceleration: how fast the robot brakes (a), in m/s².
    """
    return stop_distance + speed * speed / (2 * deceleration)
