"""The base classes of devices: sensors, which return samples, and actuators, which take commands."""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, Protocol, TypeVar, get_type_hints

from robotcore.errors import DeviceClosedError, DeviceError, InvalidCommandError, RobotcoreError
from robotcore.geometry import Pose
from robotcore.text import format_number

if TYPE_CHECKING:
    from robotcore.description import Body, Mount

__all__ = [
    "Actuator",
    "Device",
    "Rays",
    "Sample",
    "SampleT",
    "Sensor",
    "Unit",
    "build_driver_error",
    "build_invalid_command",
]

_OURS = "robotcore"
_LOOP = "robotcore.runtime.loop"
"""The module that calls apps. The stack frames above this module are not part of an app."""


def caller_location() -> str:
    """Return ``file.py:line`` of the app's code that called the framework; ``""`` if no app made the call."""
    frame: FrameType | None = sys._getframe(1)  # noqa: SLF001  Python offers no public function
    while frame and _module(frame).partition(".")[0] == _OURS:
        frame = None if _module(frame) == _LOOP else frame.f_back
    return f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}" if frame else ""


def _module(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__"))


FIND_NAN = "Look for a division by zero, or for a range of inf, in the app"
"""The remedy for a command that is NaN or infinite."""


def build_invalid_command(device: str, command: str, effect: str = "", remedy: str = FIND_NAN) -> InvalidCommandError:
    """Return the error for a command of an app without a meaning. Its message names the app's line.

    command: the command with its unit, such as ``an angle of nan rad``.
    effect: what the device did, after a comma.

    >>> error = build_invalid_command("pan", "an angle of nan rad", remedy="Give radians")
    >>> str(error).startswith("pan: the app commanded an angle of nan rad")
    True
    """
    line = caller_location()
    where = f", at {line}" if line else ""
    return InvalidCommandError(f"{device}: the app commanded {command}{where}{effect}. {remedy}")


class Sample(Protocol):
    """The fields of every sample.

    >>> from robotcore.kinds.range_sensor import Range
    >>> sample: Sample = Range(0.84, time=1.25, sequence=25)
    >>> sample.time, sample.sequence
    (1.25, 25)
    """

    @property
    def time(self) -> float:
        """The time of the measurement on the robot's clock, in seconds."""

    @property
    def sequence(self) -> int:
        """The number of the sample. It grows with each new sample of a device."""


@dataclass(frozen=True)
class Unit:
    """The unit of a field of a sample or a command, as an annotation: ``voltage: Annotated[float, Unit("V")]``.

    >>> from robotcore.hal.device import list_values
    >>> from robotcore.kinds.range_sensor import Range
    >>> list_values(Range)
    (Value(field='distance', unit='m'),)
    """

    symbol: str
    """The symbol of the unit, such as ``m/s``; empty for a number without a unit."""


class Value(NamedTuple):
    """A number in the samples of a kind, or a tuple of numbers."""

    field: str
    """The name of the field in a sample."""
    unit: str
    """The unit; empty if it has none."""


@cache
def list_values(sample: type[Any]) -> tuple[Value, ...]:
    """Return the fields of a class of samples that are annotated with a unit."""
    hints = get_type_hints(sample, include_extras=True)
    found = ((name, unit) for name, hint in hints.items() for unit in getattr(hint, "__metadata__", ()))
    return tuple(Value(name, unit.symbol) for name, unit in found if isinstance(unit, Unit))


SampleT = TypeVar("SampleT", bound=Sample)
"""A type variable for the class of a sensor's samples."""
CommandT = TypeVar("CommandT")
T = TypeVar("T")


class Device:
    """The base class of a robot's devices. The constructor does not use hardware.

    name: the name of the device, as in the robot's file.

    ``mount`` is the present pose of a mounted device on the robot in the plane. A run sets it from the robot's
    description. A device on a servo turns with it.

    >>> from robotcore import Pose
    >>> device = Device("nose")
    >>> device.mount = Pose(0.14, 0.0, 0.0)
    >>> device.mount.x
    0.14
    >>> device.close()
    >>> device
    <Device nose: closed>
    """

    kind: ClassVar[str] = ""
    """The name of the device's kind, as in a robot's file."""
    _locate: Callable[[], Pose] = staticmethod(lambda: Pose(0.0, 0.0, 0.0))

    def __init__(self, name: str) -> None:
        self.name = name
        self._is_closed = False

    @property
    def mount(self) -> Pose:
        """The present pose of the device on the robot in the plane."""
        return self._locate()

    @mount.setter
    def mount(self, pose: Pose | Callable[[], Pose]) -> None:
        self._locate = pose if callable(pose) else lambda: pose

    def __repr__(self) -> str:
        state = self.format_state()
        return f"<{type(self).__name__} {self.name}{': ' if state else ''}{state}>"

    def format_state(self) -> str:
        """Return the last sample, or the command that was sent last, as text; ``""`` without one."""
        return "closed" if self._is_closed else self._format_state()

    def _format_state(self) -> str:
        """Return the text of `format_state` for a device that is open. This uses no hardware."""
        return ""

    def close(self) -> None:
        """Release the hardware. Then a second `close` does nothing, and other methods raise DeviceClosedError."""
        if not self._is_closed:
            self._is_closed = True
            self._attempt(self._release)

    def _release(self) -> None:
        """Release the hardware. `close` calls this once."""

    def _attempt(self, method: Callable[..., T], *args: object) -> T:
        """Call a driver's method. Raise its exceptions, except RobotcoreErrors, as DeviceErrors."""
        try:
            return method(*args)
        except RobotcoreError:
            raise
        except Exception as error:
            raise build_driver_error(self.name, error) from error


class Rays(NamedTuple):
    """The rays of a sample at equal angles, for display. The angles are in radians from the sensor's direction.

    >>> Rays(start=-0.5, end=0.5, distances=(1.2, 0.8, 1.2)).distances[1]  # straight ahead
    0.8
    """

    start: float
    """The angle of the first ray."""
    end: float
    """The angle of the last ray. It is greater than ``start``."""
    distances: tuple[float, ...]
    """The distance along each ray, in metres; ``inf`` if nothing is in range."""


class Sensor(Device, ABC, Generic[SampleT]):
    """The base class of sensors, which return samples.

    >>> from robotcore.errors import DeviceClosedError
    >>> from robotcore.kinds.range_sensor import Range
    >>> class Constant(Sensor[Range]):
    ...     kind = "range_sensor"
    ...
    ...     def _newest(self):
    ...         return Range(0.84, time=1.25, sequence=25)
    >>> sensor = Constant("nose")
    >>> sensor.read()
    Range 0.84 m at 1.25 s
    >>> sensor.close()
    >>> try:
    ...     sensor.read()
    ... except DeviceClosedError as error:
    ...     print(error.device)
    nose
    """

    has_rays: ClassVar[bool] = False
    """Whether the samples have distances along rays. Recordings show them, and the conditions of worlds change them."""

    is_monitored: ClassVar[bool] = False
    """Whether a run reads the sensor once a second by itself, as it does with a battery, and continues if it fails.

    A run opens such a sensor even if its app does not use it. The app may read it too. Its samples may be old.
    """

    is_compensated: bool = False
    """Whether the samples have no described errors, such as those of a recording or a script."""

    def find_problem(self, sample: SampleT) -> str:
        """Return the problem of a sample and the remedy, such as for a low voltage; ``""`` if there is no problem.

        A run warns about the problem of a monitored sensor.
        """
        return ""

    def limit_sample(self, sample: SampleT) -> SampleT:
        """Return a sample with its values within the limits of the hardware, such as the range of a range sensor.

        Faults that change values call it, and so do mock sensors.
        """
        return sample

    def format_sample(self, sample: SampleT) -> str:
        """Return the values of a sample with their units as a text, such as ``7.40 V``."""
        formatted: Any = sample
        return str(formatted.format_values())

    def list_rays(self, sample: SampleT) -> Rays:
        """Return the rays of a sample, for a sensor that has rays."""
        raise NotImplementedError

    def change_distances(self, sample: SampleT, change: Callable[[float, int], float]) -> SampleT:
        """Return a sample with changed distances within the sensor's range, for a sensor that has rays.

        change: returns the changed distance. Its arguments are the distance in metres and the number of the ray from 0.
        """
        raise NotImplementedError

    def measure_ahead(self, sample: SampleT, mount: Mount, body: Body) -> float:
        """Return the free distance ahead of the robot in a sample, in metres; ``inf`` if nothing is in range.

        The range guard calls it for a sensor whose description looks ahead with this mount.

        mount: the mount of the sensor at the time of the sample.
        body: the body of the robot.
        """
        raise NotImplementedError

    def read(self) -> SampleT:
        """Return the newest sample, without waiting for hardware. Raises DeviceError if the sensor fails."""
        if self._is_closed:
            raise DeviceClosedError(self.name)
        try:  # as in `_attempt`, whose call takes as long as that of many drivers
            return self._newest()
        except RobotcoreError:
            raise
        except Exception as error:
            raise build_driver_error(self.name, error) from error

    @abstractmethod
    def _newest(self) -> SampleT:
        """Return the newest sample. Without a new measurement, return the last sample with its old time.

        An implementation raises an exception if the sensor fails, and never returns a made-up value.
        """


class Actuator(Device, ABC, Generic[CommandT]):
    """The base class of actuators, which take commands.

    >>> class Fan(Actuator[float]):
    ...     kind, command_unit, safe_command = "fan", "rpm", 0.0
    ...
    ...     def _limit(self, command):
    ...         return max(0.0, min(command, 3000.0))
    ...
    ...     def _apply(self, command):
    ...         print("now", self.format_command(command))
    >>> fan = Fan("cooler")
    >>> fan.send(9000.0)
    now 3000.00 rpm
    3000.0
    >>> fan.close()
    now 0.00 rpm
    """

    safe_command: ClassVar[Any] = None
    """The command of the safe state, such as a velocity of 0. None: the actuator holds its state at a stop."""

    command_unit: ClassVar[str] = ""
    """The unit of a command that is a number, such as ``rad``."""

    def format_command(self, command: CommandT) -> str:
        """Return a command with its unit as text, such as ``0.50 rad``; ``""`` for a command other than numbers."""
        numbers = command if isinstance(command, tuple) else (command,)
        if not all(isinstance(each, (int, float)) for each in numbers):
            return ""
        return f"{' '.join(map(format_number, numbers))} {self.command_unit}".rstrip()

    def send(self, command: CommandT) -> CommandT:
        """Send a command within the limits of the actuator, and return the command that was sent.

        It does not wait for hardware. Raises InvalidCommandError for a command without a meaning, such as NaN, and
        DeviceError if the actuator fails.
        """
        if self._is_closed:
            raise DeviceClosedError(self.name)
        try:
            sent = self._limit(command)
            self._apply(sent)
        except RobotcoreError:
            raise
        except Exception as error:
            raise build_driver_error(self.name, error) from error
        return sent

    def stop(self) -> None:
        """Bring the actuator into its safe state, if it has one. A closed actuator is safe already."""
        if self.safe_command is not None and not self._is_closed:
            self._attempt(self._apply, self.safe_command)

    def close(self) -> None:
        """Stop the actuator, then release the hardware, even if the stop has failed."""
        try:
            self.stop()
        finally:
            super().close()

    def limit_command(self, command: CommandT) -> CommandT:
        """Return the command that `send` would send. Raises the errors of `send` for a command without a meaning."""
        return self._attempt(self._limit, command)

    def _limit(self, command: CommandT) -> CommandT:
        """Return the command within the limits of the actuator. Raises InvalidCommandError for an invalid command."""
        return command

    @abstractmethod
    def _apply(self, command: CommandT) -> None:
        """Send a command that is within the limits, without waiting for the hardware.

        A driver of slow hardware stores the command, and a thread of the driver sends it.
        """


def build_driver_error(device: str, error: Exception, kind: str = "driver-error") -> DeviceError:
    """Return the error for an exception of a driver. The caller raises it from that exception.

    device: the name of the device.
    error: the exception of the driver.
    kind: the kind of the new error.

    >>> error = build_driver_error("nose", OSError("unplugged"))
    >>> str(error), error.kind
    ('nose: OSError: unplugged', 'driver-error')
    """
    return DeviceError(device, f"{type(error).__name__}: {error}".removesuffix(": "), kind=kind)
