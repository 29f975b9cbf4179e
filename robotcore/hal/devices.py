"""Motors, sensors and displays, and their samples, as apps use them and drivers implement them."""

from __future__ import annotations

import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import FrameType
from typing import Generic, ParamSpec, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from robotcore.errors import DeviceClosedError, DeviceError, InvalidCommandError, RobotcoreError
from robotcore.geometry import Pose
from robotcore.optics import Intrinsics

_OURS = "robotcore"
_LOOP = "robotcore.runtime.loop"
"""It calls apps: what is outside of it is none."""


def caller_location() -> str:
    """Return ``file.py:line`` of the innermost code on this thread's stack that is not the framework's.

    Empty where the framework asked of itself.
    """
    frame: FrameType | None = sys._getframe(1)  # noqa: SLF001  the one way to see who calls
    while frame and _module(frame).partition(".")[0] == _OURS:
        frame = None if _module(frame) == _LOOP else frame.f_back
    return f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}" if frame else ""


def _module(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__"))


Image = NDArray[np.uint8]
"""Height x width x 3, ``uint8``, BGR, top-left origin; height x width where it is grey."""


class Sample(Protocol):
    """What every sample has: when it was captured, and which one of its device it is."""

    @property
    def time(self) -> float: ...
    @property
    def sequence(self) -> int: ...


SampleT = TypeVar("SampleT", bound=Sample)
P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Range:
    """A distance in metres; ``inf`` where the sensor vouches that nothing is in range.

    ``point`` is the detected point in the sensor's frame, where a simulator knows it.
    """

    distance: float
    time: float
    sequence: int
    point: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class Angle:
    """A wheel's angle in radians since the robot was opened; forward is positive."""

    angle: float
    time: float
    sequence: int


@dataclass(frozen=True, slots=True)
class Voltage:
    """A battery's voltage in volts."""

    voltage: float
    time: float
    sequence: int


@dataclass(frozen=True, eq=False)
class Frame:
    """A picture: BGR, (height, width, 3), top-left origin, read-only."""

    image: Image
    time: float
    sequence: int

    @cached_property
    def grey(self) -> Image:
        """The same picture in grey, (height, width), read-only."""
        import cv2

        grey = np.asarray(cv2.cvtColor(self.image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        grey.flags.writeable = False
        return grey


class Device:
    """Something on a robot, known by its name. A constructor touches no hardware."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._is_closed = False

    def close(self) -> None:
        """Let the hardware go. May be called again; every other call then raises."""
        if not self._is_closed:
            self._is_closed = True
            self._attempt(self._release)

    def _release(self) -> None:
        """Give back what opening took. Called once."""

    def _require_open(self) -> None:
        if self._is_closed:
            raise DeviceClosedError(self.name)

    def _attempt(self, hook: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a driver's hook; an error that the driver did not translate becomes a DeviceError.

        What is called in each tick does the same in its own body, which takes a fifteenth off what a tick costs.
        """
        try:
            return hook(*args, **kwargs)
        except RobotcoreError:
            raise
        except Exception as error:
            raise self._untranslated(error) from error

    def _untranslated(self, error: Exception) -> DeviceError:
        return DeviceError(self.name, f"{type(error).__name__}: {error}".removesuffix(": "))


class Motor(Device, ABC):
    """A wheel's motor; a positive velocity drives the robot forward, on both sides."""

    kind = "motor"

    def __init__(self, name: str, max_velocity: float) -> None:
        super().__init__(name)
        self.max_velocity = max_velocity

    def set_velocity(self, rad_s: float) -> float:
        """Turn at ``rad_s``; return the velocity in fact sent, after ``max_velocity``.

        Raises InvalidCommandError, and stops, where ``rad_s`` is NaN or infinite.
        """
        self._require_open()
        limit = self.max_velocity
        sent = rad_s if -limit <= rad_s <= limit else self._limit_velocity(rad_s)
        try:
            self._apply(sent)
        except RobotcoreError:
            raise
        except Exception as error:
            raise self._untranslated(error) from error
        return sent

    def stop(self) -> None:
        """Stop now. Never refused: on a closed motor it does nothing, for closing stopped it."""
        if not self._is_closed:
            self._attempt(self._apply, 0.0)

    def close(self) -> None:
        """Stop, then let the hardware go, even where the stop failed."""
        try:
            self.stop()
        finally:
            super().close()

    def _limit_velocity(self, rad_s: float) -> float:
        if not math.isfinite(rad_s):
            self.stop()
            raise invalid_velocity(self.name, rad_s)
        return math.copysign(self.max_velocity, rad_s)

    @abstractmethod
    def _apply(self, rad_s: float) -> None:
        """Send a finite velocity within the limits."""


class VelocityOutput(Protocol):
    """Commands one motor: a motor of a driver, or the layers over it."""

    @property
    def name(self) -> str:
        """The motor's name."""

    def set_velocity(self, rad_s: float, /) -> float:
        """Send a velocity in rad/s; return the velocity that the motor accepted."""

    def stop(self) -> None:
        """Stop the motor."""


class Sensor(Device, ABC, Generic[SampleT]):
    """A device that is read."""

    kind = "sensor"

    def read(self) -> SampleT:
        """Return the newest sample, without waiting for hardware.

        Raises DeviceError where the device failed: it never makes a value up.
        """
        self._require_open()
        try:
            return self._newest()
        except RobotcoreError:
            raise
        except Exception as error:
            raise self._untranslated(error) from error

    @abstractmethod
    def _newest(self) -> SampleT:
        """Return the newest sample; the same one, with its old time, where there is no newer."""


class RangeSensor(Sensor[Range]):
    """A distance ahead. ``cone`` is the full angle; nearer than ``min_range`` reads ``min_range``.

    ``mount`` is where it sits on the robot, in plan; a robot's assembly sets it from the description.
    """

    kind = "range_sensor"
    mount = Pose(0.0, 0.0, 0.0)

    def __init__(self, name: str, *, min_range: float, max_range: float, cone: float) -> None:
        super().__init__(name)
        self.min_range, self.max_range, self.cone = min_range, max_range, cone


class Camera(Sensor[Frame]):
    """A picture of what is ahead; ``mount`` as for a range sensor."""

    kind = "camera"
    mount = Pose(0.0, 0.0, 0.0)

    def __init__(self, name: str, intrinsics: Intrinsics) -> None:
        super().__init__(name)
        self.intrinsics = intrinsics


class Encoder(Sensor[Angle]):
    """The angle of a wheel."""

    kind = "encoder"


class Battery(Sensor[Voltage]):
    """The voltage of the robot's battery, which nobody drives by: it may be old, or fail, and no run ends for it.

    Below ``warn_below`` volts it is to be charged; a robot's assembly sets it from the description.
    """

    kind = "battery"
    warn_below: float | None = None


class Display(Device, ABC):
    """Where an app shows its annotated picture."""

    kind = "display"

    def show(self, image: Image) -> None:
        """Show a BGR or grey picture, top-left origin."""
        self._require_open()
        self._attempt(self._show, image)

    @abstractmethod
    def _show(self, image: Image) -> None:
        """Hand a picture on."""


def invalid_velocity(name: str, rad_s: float) -> InvalidCommandError:
    """Return the error for a velocity that is no number, with the line of the app that asked for it."""
    line = caller_location()
    where = f", at {line}" if line else ""
    return InvalidCommandError(
        f"{name}: a velocity of {rad_s} rad/s was asked for{where}; it must be a finite number. "
        "All motors were stopped; look for a division by zero or a range of inf in the app"
    )


class MemoryDisplay(Display):
    """Keeps a copy of the newest picture in ``picture``."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.picture: Image | None = None

    def _show(self, image: Image) -> None:
        self.picture = image.copy()
