"""Mock devices: sensors with scripted readings, motors that record commands, and displays that record pictures."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import Enum
from functools import partial
from numbers import Real
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from robotcore.errors import DeviceError, UsageError
from robotcore.hal.clock import Clock
from robotcore.kinds.battery import Battery, Voltage
from robotcore.kinds.camera import Camera, CameraDescription, Frame
from robotcore.kinds.display import Display
from robotcore.kinds.encoder import Angle, Encoder
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.kinds.range_sensor import Range, RangeSensor, RangeSensorDescription
from robotcore.optics import Image, Intrinsics

ValueT = TypeVar("ValueT")


class _Lost(Enum):
    LOST = "lost"


LOST = _Lost.LOST
"""A reading for scripts: in this tick, the sensor has no new sample and returns its last one again."""

Script = Any | Sequence[Any] | Callable[[float], Any]
"""The readings of a sensor: a constant, a list with one reading per tick, or a function of the time in seconds.

After the end of a list, its last reading is repeated. If a reading is an exception, the sensor raises DeviceError.
"""


class Playback(Generic[ValueT]):
    """Plays the script of a sensor: each tick has one reading.

    device: the sensor's name, for error messages.
    rate_hz: the number of ticks per second.
    convert: checks a reading, and returns it as the value of a sample.

    Raises UsageError if a constant or a list has no valid readings.
    """

    def __init__(
        self, device: str, script: Script, clock: Clock, rate_hz: float, convert: Callable[[Any], ValueT]
    ) -> None:
        if isinstance(script, (list, tuple)) and not script:
            raise UsageError(f"{device}: the script is empty. Give it at least one reading", kind="script-empty")
        self._device, self._script, self._clock, self._rate_hz = device, script, clock, rate_hz
        self._convert = convert
        for reading in () if callable(script) else script if isinstance(script, (list, tuple)) else (script,):
            if reading is not LOST and not isinstance(reading, Exception):
                convert(reading)
        self._played_until = -1
        self._newest: tuple[ValueT, float, int] | None = None
        self._failure: Exception | None = None

    def newest(self) -> tuple[ValueT, float, int]:
        """Play the script until the current tick, and return the newest sample: its value, its time, its sequence.

        Raises DeviceError if the current reading is an exception, or if all readings so far are `LOST`.
        """
        now = self._clock.now()
        tick = math.floor(now * self._rate_hz + 1e-6)
        for due in range(self._played_until + 1, tick + 1):
            self._play(due, min(due / self._rate_hz, now))
        if self._failure:
            raise DeviceError(self._device, str(self._failure)) from self._failure
        if self._newest is None:
            raise DeviceError(
                self._device,
                "all readings of the script are LOST so far. Begin the script with a reading",
                kind="nothing-read",
            )
        return self._newest

    def _play(self, tick: int, time: float) -> None:
        self._played_until = tick
        reading = self._script
        if isinstance(reading, (list, tuple)):
            reading = reading[min(tick, len(reading) - 1)]
        elif callable(reading):
            reading = reading(time)
        self._failure = reading if isinstance(reading, Exception) else None
        if self._failure or reading is LOST:
            return
        sequence = self._newest[2] + 1 if self._newest else 0
        self._newest = self._convert(reading), time, sequence


GREY = 128


class Command(NamedTuple):
    """A command that a motor received.

    >>> Command(0.05, 4.0).velocity
    4.0
    """

    time: float
    """The time of the command on the robot's clock, in seconds."""

    velocity: float
    """The commanded velocity, in rad/s."""


class MockMotor(Motor):
    """A motor that records its commands in ``commands``, and turns exactly at the commanded velocity."""

    def __init__(self, description: MotorDescription, clock: Clock) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self.commands: list[Command] = []
        self._clock = clock
        self._angle_at_command = 0.0

    @property
    def velocity(self) -> float:
        """The last commanded velocity in rad/s; 0 before the first command."""
        return self.commands[-1].velocity if self.commands else 0.0

    @property
    def angle(self) -> float:
        """The angle by which the motor has turned since it was opened, in radians."""
        since = self.commands[-1].time if self.commands else 0.0
        return self._angle_at_command + self.velocity * (self._clock.now() - since)

    def _apply(self, rad_s: float) -> None:
        self._angle_at_command = self.angle
        self.commands.append(Command(self._clock.now(), rad_s))


class MockRangeSensor(RangeSensor):
    """A range sensor that returns scripted distances in metres, limited to its range."""

    def __init__(self, description: RangeSensorDescription, script: Script, clock: Clock, rate_hz: float) -> None:
        super().__init__(
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._playback = Playback(self.name, script, clock, rate_hz, self._within_limits)

    def _newest(self) -> Range:
        return Range(*self._playback.newest())

    def _within_limits(self, distance: Any) -> float:
        if not isinstance(distance, Real) or math.isnan(distance) or float(distance) < 0:
            raise UsageError(
                f"{self.name}: the script has {distance!r}. Give a distance in metres, inf, LOST or an exception",
                kind="script-reading",
            )
        metres = float(distance)
        return math.inf if metres > self.max_range else max(metres, self.min_range)


class MockCamera(Camera):
    """A camera that returns scripted pictures: BGR, ``uint8`` of shape (height, width, 3)."""

    def __init__(self, description: CameraDescription, script: Script, clock: Clock, rate_hz: float) -> None:
        super().__init__(description.name, description.intrinsics)
        self._playback = Playback(self.name, script, clock, rate_hz, self._check_picture)

    def _newest(self) -> Frame:
        return Frame(*self._playback.newest())

    def _check_picture(self, picture: Any) -> Image:
        expected = (self.intrinsics.height, self.intrinsics.width, 3)
        if not isinstance(picture, np.ndarray) or picture.shape != expected or picture.dtype != np.uint8:
            raise UsageError(
                f"{self.name}: the script has {_describe(picture)}. Give uint8 pictures of shape {expected}",
                kind="script-reading",
            )
        image: Image = picture.copy(order="C")
        image.flags.writeable = False
        return image


class MockEncoder(Encoder):
    """An encoder that returns scripted angles in radians."""

    def __init__(self, name: str, script: Script, clock: Clock, rate_hz: float) -> None:
        super().__init__(name)
        self._playback = Playback(name, script, clock, rate_hz, partial(_convert_number, name))

    def _newest(self) -> Angle:
        return Angle(*self._playback.newest())


class MockBattery(Battery):
    """A battery that returns scripted voltages in volts."""

    def __init__(self, name: str, script: Script, clock: Clock, rate_hz: float) -> None:
        super().__init__(name)
        self._playback = Playback(name, script, clock, rate_hz, partial(_convert_number, name))

    def _newest(self) -> Voltage:
        return Voltage(*self._playback.newest())


class MockDisplay(Display):
    """A display that records its pictures in ``pictures``."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.pictures: list[Image] = []

    def _apply(self, image: Image) -> None:
        self.pictures.append(image.copy())


def _convert_number(device: str, reading: Any) -> float:
    if not isinstance(reading, Real):
        raise UsageError(
            f"{device}: the script has {reading!r}. Give a number, LOST or an exception", kind="script-reading"
        )
    return float(reading)


def grey_picture(intrinsics: Intrinsics) -> Image:
    """Return a grey picture of a camera's size: BGR, ``uint8`` of shape (height, width, 3)."""
    return np.full((intrinsics.height, intrinsics.width, 3), GREY, dtype=np.uint8)


def _describe(picture: Any) -> str:
    return f"{picture.dtype} of shape {picture.shape}" if isinstance(picture, np.ndarray) else repr(picture)
