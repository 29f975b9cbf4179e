"""Mock devices of any kind: sensors with scripted readings, and actuators that record their commands."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import MISSING, fields
from enum import Enum
from functools import cache, cached_property
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np

from robotcore.description import DeviceDescription
from robotcore.errors import DeviceError, UsageError
from robotcore.hal.clock import Clock
from robotcore.hal.device import Actuator, Sample, Sensor
from robotcore.hal.kind import build_sensor, load_kind
from robotcore.hal.sample_types import NUMBERS, describe_expected
from robotcore.kinds.display import Display
from robotcore.kinds.motor import Motor
from robotcore.optics import Image


class _Lost(Enum):
    LOST = "lost"


LOST = _Lost.LOST
"""A reading for scripts: in this tick, the sensor has no new sample and returns its last one again."""

Script = Any | Sequence[Any] | Callable[[float], Any]
"""The readings of a sensor: a constant, a list with one reading per tick, or a function of the time in seconds.

A reading is the value of a sample, such as 0.84 for a range sensor. For a sample with several values it is a mapping of
field to value; a field that is not in the mapping has its value without a script. After the end of a list, its last
reading is repeated. If a reading is an exception, the sensor raises DeviceError.
"""


class Readings:
    """Converts readings of a script to samples of a sensor's kind."""

    def __init__(self, description: DeviceDescription) -> None:
        self._description, self._kind = description, load_kind(description.kind)
        self._sensor = build_sensor(description, lambda: None)
        hints = get_type_hints(self._kind.sample)
        values = [each for each in fields(self._kind.sample) if each.name not in ("time", "sequence")]
        self._types = {each.name: hints[each.name] for each in values}
        self._required = [each.name for each in values if each.default is MISSING]

    @cached_property
    def default(self) -> Mapping[str, Any]:
        """The values of a sample without a script, by field."""
        if self._kind.default_reading is None:
            zeros = {name: _build_zero(self._types[name]) for name in self._required}
            return {name: zero for name, zero in zeros.items() if zero is not None}
        reading = self._kind.default_reading(self._description)
        return reading if isinstance(reading, Mapping) else {self._required[0]: reading}

    def convert(self, reading: Any, time: float = 0.0, sequence: int = 0) -> Any:
        """Return a sample with the values of a reading. Raises UsageError if the sensor cannot have this reading."""
        try:
            values = {name: self._convert_value(name, value) for name, value in self._name_values(reading).items()}
            sample = self._kind.sample(**values, time=time, sequence=sequence)
            if self._kind.validate_sample:
                sample = self._kind.validate_sample(self._description, sample)
            return self._sensor.limit_sample(sample)
        except UsageError:
            raise
        except ValueError as error:
            name = self._description.name
            raise UsageError(
                f"{name}: the script has {_describe(reading)}. Give {error}, LOST or an exception",
                kind="script-reading",
                device=name,
                reading=_describe(reading),
            ) from error

    def check(self, script: Script) -> None:
        """Raise UsageError if the script has no reading, or a wrong one. A function is not called."""
        if isinstance(script, (list, tuple)) and not script:
            name = self._description.name
            text = f"{name}: the script is empty. Give it at least one reading"
            raise UsageError(text, kind="script-empty", device=name)
        if callable(script):
            return
        for reading in script if isinstance(script, (list, tuple)) else [script]:
            if reading is not LOST and not isinstance(reading, Exception):
                self.convert(reading)

    def _name_values(self, reading: Any) -> Mapping[str, Any]:
        if not isinstance(reading, Mapping) and len(self._required) == 1:
            return {self._required[0]: reading}
        if isinstance(reading, Mapping) and reading.keys() <= self._types.keys():
            values = {**self.default, **reading}
            if missing := ", ".join(name for name in self._required if name not in values):
                name = self._description.name
                raise UsageError(
                    f"{name}: the mock sensor has no value of {missing}. Give one in its script, such as readings="
                    f"{{{name!r}: {{{missing.split(', ')[0]!r}: ...}}}}, or give the kind a default_reading",
                    kind="script-incomplete",
                    device=name,
                )
            return values
        raise ValueError(f"a mapping of fields ({', '.join(self._types)}) to values")

    def _convert_value(self, name: str, value: Any) -> Any:
        if (expected := self._types[name]) not in NUMBERS:
            form = "" if self._kind.validate_sample else describe_expected(expected, value)
            if form:
                raise ValueError(f"{form} as {name}")
            return value
        classes, form = NUMBERS[expected]
        if isinstance(value, classes):
            if self._kind.validate_sample or math.isfinite(value):
                return expected(value)
            form = "a finite number"
        raise ValueError(f"{form} as {name}" if len(self._required) > 1 else form)


class Playback:
    """Plays the script of a sensor: each tick has one reading. Without a script, each has the reading of the kind.

    rate_hz: the number of ticks per second.
    """

    def __init__(self, description: DeviceDescription, script: Script | None, clock: Clock, rate_hz: float) -> None:
        self._device, self._readings = description.name, Readings(description)
        self._script = self._readings.default if script is None else script
        self._clock, self._rate_hz = clock, rate_hz
        self._played_until = -1
        self._newest: Sample | None = None
        self._failure: Exception | None = None

    def newest(self) -> Sample:
        """Play the script until the current tick, and return the newest sample.

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
        self._newest = self._readings.convert(reading, time, self._newest.sequence + 1 if self._newest else 0)


def open_sensor(description: DeviceDescription, script: Script | None, clock: Clock, rate_hz: float) -> Sensor[Any]:
    """Return a sensor of the described kind that plays a script.

    script: the script; None stands for the reading that the kind has without one.
    rate_hz: the number of ticks per second.
    """
    sensor = build_sensor(description, Playback(description, script, clock, rate_hz).newest)
    sensor.is_compensated = True  # an app gets the readings of its script
    return sensor


class Command(NamedTuple):
    """A command that an actuator received.

    >>> Command(0.05, 4.0).velocity
    4.0
    """

    time: float
    """The time of the command on the robot's clock, in seconds."""

    value: Any
    """The command: the velocity of a motor in rad/s, a copy of the picture of a display."""

    @property
    def velocity(self) -> float:
        """The commanded velocity of a motor, in rad/s."""
        return float(self.value)


class MockActuator(Actuator[Any]):
    """An actuator that records its commands in ``commands``. `open_actuator` adds the class of a kind."""

    def __init__(self, description: DeviceDescription, clock: Clock) -> None:
        super().__init__(description.name, **description.arguments())
        self.commands: list[Command] = []
        self._clock = clock

    def _apply(self, command: Any) -> None:
        self.commands.append(Command(self._clock.now(), deepcopy(command)))


class MockMotor(MockActuator, Motor):
    """A motor that records its commands in ``commands``, and turns exactly at the commanded velocity."""

    def __init__(self, description: DeviceDescription, clock: Clock) -> None:
        super().__init__(description, clock)
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

    def _apply(self, command: float) -> None:
        self._angle_at_command = self.angle
        super()._apply(command)


class MockDisplay(MockActuator, Display):
    """A display that records its commands in ``commands``."""

    @property
    def pictures(self) -> list[Image]:
        """Copies of the pictures that the display has shown, in their order."""
        return [command.value for command in self.commands]


def open_actuator(description: DeviceDescription, clock: Clock) -> MockActuator:
    """Return an actuator of the described kind that records its commands."""
    return _actuator_class(description.kind)(description, clock)


@cache
def _actuator_class(kind: str) -> type[MockActuator]:
    device: Any = load_kind(kind).device
    own = {Motor.kind: MockMotor, Display.kind: MockDisplay}.get(kind)
    return own or type(f"Mock{device.__name__}", (MockActuator, device), {})


def _build_zero(expected: Any) -> Any:
    """Return 0 as a value of a type, with a tuple of zeros for a tuple of a fixed length; None for other types."""
    if expected in NUMBERS:
        return expected()
    arguments = get_args(expected)
    is_fixed = get_origin(expected) is tuple and set(arguments) <= NUMBERS.keys()
    return tuple(each() for each in arguments) if is_fixed else None


def _describe(reading: Any) -> str:
    return f"{reading.dtype} of shape {reading.shape}" if isinstance(reading, np.ndarray) else reprlib.repr(reading)
