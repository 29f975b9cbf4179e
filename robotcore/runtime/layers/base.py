"""The interfaces of layers. A layer changes or observes the calls between an app and the devices of a driver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from robotcore.hal.clock import Clock
from robotcore.hal.device import Actuator, SampleT, Sensor
from robotcore.hal.drive import WheelPath
from robotcore.kinds.motor import Motor
from robotcore.safety.command_filter import CommandFilter
from robotcore.safety.latch import Latch

__all__ = ["Layer", "MotorOutput"]

Reader = Callable[[], SampleT]
"""A function that returns the newest sample of one sensor."""

Send = Callable[[Any], Any]
"""A function that sends a command to one actuator, and returns the command that was sent."""


@dataclass(frozen=True, eq=False, slots=True)
class MotorOutput:
    """The two functions that command one motor. A layer can replace both.

    >>> output = MotorOutput("left_motor", set_velocity=lambda rad_s: min(rad_s, 10.0), stop=lambda: None)
    >>> output.set_velocity(12.0)
    10.0
    """

    name: str
    """The motor's name in the robot's description."""
    set_velocity: Callable[[float], float]
    """Sends a velocity in rad/s; returns the velocity that the motor accepted."""
    stop: Callable[[], None]
    """Stops the motor."""

    @classmethod
    def from_motor(cls, motor: Motor) -> MotorOutput:
        """Return the output of a driver's motor."""
        return cls(motor.name, motor.set_velocity, motor.stop)


class Layer:
    """The base class of layers, which lie between a driver's devices and the safety stage.

    Each method gets a function or a clock that leads to the driver. It returns one that leads through this layer. By
    default it returns its argument, so that the layer changes nothing.

    >>> from robotcore.runtime.layers.base import MotorOutput
    >>> class HalfSpeed(Layer):
    ...     def motor(self, motor):
    ...         return MotorOutput(motor.name, lambda rad_s: motor.set_velocity(rad_s / 2), motor.stop)
    >>> output = MotorOutput("left_motor", set_velocity=lambda rad_s: rad_s, stop=lambda: None)
    >>> HalfSpeed().motor(output).set_velocity(8.0)
    4.0
    """

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return the function that reads ``sensor`` through this layer. It may call ``read``."""
        return read

    def motor(self, motor: MotorOutput) -> MotorOutput:
        """Return the output that commands a motor through this layer. It may call ``motor``."""
        return motor

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        """Return the function that commands ``actuator``, no motor, through this layer. It may call ``send``."""
        return send

    def clock(self, clock: Clock) -> Clock:
        """Return the clock that the loop uses through this layer. It may wrap ``clock``."""
        return clock


class Tap(Layer):
    """A layer that also gets the app's commands and the path of the wheels for the odometry.

    The recorder and the replay are taps.
    """

    def command_filter(self, inner: CommandFilter) -> CommandFilter:
        """Return the command filter to which the drive sends its commands. It may wrap ``inner``."""
        return inner

    def standalone_motor(self, motor: MotorOutput) -> MotorOutput:
        """Return the output with which the app commands a motor outside the drive. It may wrap ``motor``."""
        return motor

    def wheel_path(self, read: Callable[[], WheelPath]) -> Callable[[], WheelPath]:
        """Return the function that reads the path of the wheels for the odometry. It may call ``read``."""
        return read

    def latch(self, latch: Latch) -> None:
        """Receive the latch of the run. A run calls this once, before it reads the first sensor."""

    def end_ticks(self) -> None:
        """Receive the end of the last tick before a pause of a live robot, or after an error or a signal.

        Calls that belong to no tick may follow, such as those of the app's clean-up.
        """

    def resume_ticks(self) -> None:
        """Receive the start of the next call of a live robot, possibly after `end_ticks`."""
