"""The interfaces of layers: what lies between a driver's devices and the app."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Display, Image, Motor, Range, RangeSensor, SampleT, Sensor
from robotcore.safety import CommandFilter, Latch

Reader = Callable[[], SampleT]
"""Returns the newest sample of one sensor."""

Show = Callable[[Image], None]
"""Shows a picture on one display."""


@dataclass(frozen=True, eq=False, slots=True)
class MotorOutput:
    """The two calls that command one motor. A layer replaces one or both of them."""

    name: str
    """The motor's name in the robot's description."""
    set_velocity: Callable[[float], float]
    """Sends a velocity in rad/s; returns the velocity that the motor accepted."""
    stop: Callable[[], None]
    """Stops the motor."""

    @classmethod
    def of(cls, motor: Motor) -> MotorOutput:
        """Return the output of a driver's motor."""
        return cls(motor.name, motor.set_velocity, motor.stop)


_REMOVED_HOOKS = {"camera", "range_sensor", "encoder", "battery"}
"""Hooks of former versions. A fault in another package that still defines one would have no effect."""


class Layer:
    """Lies between the devices of a driver and the safety stage. A hook that a subclass leaves out changes nothing.

    Each hook gets the call as the layers below offer it, and returns the call that the layers above use.
    """

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if removed := _REMOVED_HOOKS & vars(cls).keys():
            raise TypeError(f"{cls.__name__}.{min(removed)} is never called. Define sensor(self, sensor, read) instead")

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return the function that reads ``sensor`` through this layer."""
        return read

    def motor(self, motor: MotorOutput) -> MotorOutput:
        """Return the output that commands a motor through this layer."""
        return motor

    def display(self, display: Display, show: Show) -> Show:
        """Return the function that shows a picture on ``display`` through this layer."""
        return show

    def clock(self, clock: Clock) -> Clock:
        """Return the clock by which the loop sleeps."""
        return clock


class Tap(Layer):
    """A layer that also sees the calls above the safety stage: the app's commands and the odometry's input.

    The recorder and the replay are taps.
    """

    def command_filter(self, inner: CommandFilter) -> CommandFilter:
        """Return the command filter that the drive uses."""
        return inner

    def standalone_motor(self, motor: MotorOutput) -> MotorOutput:
        """Return the output by which the app commands a motor outside the drive."""
        return motor

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        """Return the function that reads the wheel angles for the odometry, in radians."""
        return read

    def latch(self, latch: Latch) -> None:
        """Receive the latch of the run, once, before the first read."""


def limit_reading(sensor: RangeSensor, reading: Range, distance: float) -> Range:
    """Return a reading with another distance in metres: at least the sensor's minimum, ``inf`` beyond its maximum."""
    if distance > sensor.max_range:
        return replace(reading, distance=inf, point=None)
    return replace(reading, distance=max(distance, sensor.min_range))
