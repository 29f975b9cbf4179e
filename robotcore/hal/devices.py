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
"""The module that calls apps. The functions that called this module are not part of an app."""


def caller_location() -> str:
    """Return ``file.py:line`` of the app's line that called the framework. It is for error messages.

    The text is empty if no app's code made the call.
    """
    frame: FrameType | None = sys._getframe(1)  # noqa: SLF001  Python offers no public function
    while frame and _module(frame).partition(".")[0] == _OURS:
        frame = None if _module(frame) == _LOOP else frame.f_back
    return f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}" if frame else ""


def _module(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__"))


Image = NDArray[np.uint8]
"""A BGR picture of shape (height, width, 3), or a grey one of shape (height, width), as ``uint8``.

The origin is the top left corner.
"""


class Sample(Protocol):
    """The fields that every sample has."""

    @property
    def time(self) -> float:
        """The time of capture on the robot's clock, in seconds."""

    @property
    def sequence(self) -> int:
        """The number of the sample; a later sample of the same device has a higher one."""


SampleT = TypeVar("SampleT", bound=Sample)
P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Range:
    """A sample of a range sensor.

    >>> Range(distance=0.84, time=1.25, sequence=25).distance
    0.84
    """

    distance: float
    """The distance in metres. It is ``inf`` if the sensor has measured that nothing is in range."""
    time: float
    """The time of capture in seconds."""
    sequence: int
    """The number of the sample."""
    point: tuple[float, float, float] | None = None
    """The detected point in the sensor's frame, in metres. Only some simulators provide it."""


@dataclass(frozen=True, slots=True)
class Angle:
    """A sample of an encoder."""

    angle: float
    """The angle by which the wheel has turned since the robot was opened, in radians, positive forward."""
    time: float
    """The time of capture in seconds."""
    sequence: int
    """The number of the sample."""


@dataclass(frozen=True, slots=True)
class Voltage:
    """A sample of a battery."""

    voltage: float
    """The voltage, in volts."""
    time: float
    """The time of capture in seconds."""
    sequence: int
    """The number of the sample."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A sample of a camera.

    >>> frame = Frame(np.zeros((120, 160, 3), np.uint8), time=1.25, sequence=25)
    >>> frame
    <Frame 160x120, t=1.25 s, sequence 25>
    >>> frame.grey.shape
    (120, 160)
    """

    image: Image
    """The BGR picture, shape (height, width, 3), read-only. The origin is the top left corner."""
    time: float
    """The time of capture in seconds."""
    sequence: int
    """The number of the sample."""

    def __repr__(self) -> str:
        height, width = self.image.shape[:2]
        return f"<Frame {width}x{height}, t={self.time:g} s, sequence {self.sequence}>"

    @cached_property
    def grey(self) -> Image:
        """The picture in grey, shape (height, width), read-only."""
        import cv2

        grey = np.asarray(cv2.cvtColor(self.image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        grey.flags.writeable = False
        return grey


class Device:
    """A device of a robot. Its constructor touches no hardware."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._is_closed = False

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name!r}{', closed' if self._is_closed else ''}>"

    def close(self) -> None:
        """Release the hardware. A second `close` does nothing. Any other method then raises DeviceClosedError."""
        if not self._is_closed:
            self._is_closed = True
            self._attempt(self._release)

    def _release(self) -> None:
        """Release the hardware. Called once."""

    def _require_open(self) -> None:
        if self._is_closed:
            raise DeviceClosedError(self.name)

    def _attempt(self, hook: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a driver's method. Raise an exception other than RobotcoreError as a DeviceError.

        The methods that run in each tick contain these lines themselves, which shortens a tick by a fifteenth.
        """
        try:
            return hook(*args, **kwargs)
        except RobotcoreError:
            raise
        except Exception as error:
            raise self._build_device_error(error) from error

    def _build_device_error(self, error: Exception) -> DeviceError:
        return DeviceError(self.name, f"{type(error).__name__}: {error}".removesuffix(": "), kind="driver-error")


class Motor(Device, ABC):
    """A motor. A positive velocity drives the robot forward, on both sides.

    ``max_velocity`` is its limit in rad/s.
    """

    def __init__(self, name: str, max_velocity: float) -> None:
        super().__init__(name)
        self.max_velocity = max_velocity

    def set_velocity(self, rad_s: float) -> float:
        """Turn at ``rad_s``, limited to ``max_velocity``. Return the velocity that was sent, in rad/s.

        If ``rad_s`` is NaN or infinite, the motor stops and InvalidCommandError is raised. Raises DeviceError if the
        device fails.
        """
        self._require_open()
        if not math.isfinite(rad_s):
            self.stop()
            raise invalid_velocity(self.name, rad_s)
        limit = self.max_velocity
        sent = limit if rad_s > limit else -limit if rad_s < -limit else rad_s  # noqa: FURB136  15 times faster
        try:
            self._apply(sent)
        except RobotcoreError:
            raise
        except Exception as error:
            raise self._build_device_error(error) from error
        return sent

    def stop(self) -> None:
        """Stop now. On a closed motor this does nothing, because closing has stopped it."""
        if not self._is_closed:
            self._attempt(self._apply, 0.0)

    def close(self) -> None:
        """Stop, then release the hardware, even if the stop failed."""
        try:
            self.stop()
        finally:
            super().close()

    @abstractmethod
    def _apply(self, rad_s: float) -> None:
        """Send a finite velocity within the limits."""


class VelocityOutput(Protocol):
    """The interface for commands to one motor. A driver's motor has it, and so have the layers."""

    @property
    def name(self) -> str:
        """The motor's name."""

    def set_velocity(self, rad_s: float, /) -> float:
        """Send a velocity in rad/s; return the velocity that the motor accepted."""

    def stop(self) -> None:
        """Stop the motor."""


class Sensor(Device, ABC, Generic[SampleT]):
    """A device that returns samples."""

    def read(self) -> SampleT:
        """Return the newest sample, without waiting for hardware.

        Raises DeviceError if the device fails. A driver never invents a value.
        """
        self._require_open()
        try:
            return self._newest()
        except RobotcoreError:
            raise
        except Exception as error:
            raise self._build_device_error(error) from error

    @abstractmethod
    def _newest(self) -> SampleT:
        """Return the newest sample. If there is no new one, return the last sample with its old time."""


class RangeSensor(Sensor[Range]):
    """A sensor of the distance ahead, such as an ultrasonic module.

    min_range, max_range: the shortest and the longest distance that the sensor measures, in metres. A shorter distance
    is returned as ``min_range``.
    cone: the full opening angle in radians.

    ``mount`` is the sensor's pose on the robot in the plane. A run sets it from the description.
    """

    mount = Pose(0.0, 0.0, 0.0)

    def __init__(self, name: str, *, min_range: float, max_range: float, cone: float) -> None:
        super().__init__(name)
        self.min_range, self.max_range, self.cone = min_range, max_range, cone


class Camera(Sensor[Frame]):
    """A camera. ``intrinsics`` is its pinhole model. ``mount`` is its pose on the robot in the plane."""

    mount = Pose(0.0, 0.0, 0.0)

    def __init__(self, name: str, intrinsics: Intrinsics) -> None:
        super().__init__(name)
        self.intrinsics = intrinsics


class Encoder(Sensor[Angle]):
    """A sensor of a wheel's angle."""


class Battery(Sensor[Voltage]):
    """A sensor of a battery's voltage. A run goes on if the sensor fails or if its sample is old.

    A run warns if the voltage is below ``warn_below`` volts. It sets this limit from the robot's description.
    """

    warn_below: float | None = None


SENSOR_KINDS = (Camera, RangeSensor, Encoder, Battery)
"""The kinds of sensors. A driver's sensor inherits one of them."""


class Display(Device, ABC):
    """Shows the annotated picture of an app."""

    def show(self, image: Image) -> None:
        """Show a BGR or grey picture with its origin top left. Raises DeviceError if the device fails."""
        self._require_open()
        self._attempt(self._show, image)

    @abstractmethod
    def _show(self, image: Image) -> None:
        """Show a picture on the hardware."""


def invalid_velocity(name: str, rad_s: float) -> InvalidCommandError:
    """Return the error for a velocity that is not finite. Its message contains the app's line that gave the command."""
    line = caller_location()
    where = f", at {line}" if line else ""
    return InvalidCommandError(
        f"{name}: a velocity of {rad_s} rad/s was asked for{where}; it must be a finite number. "
        "All motors were stopped; look for a division by zero or a range of inf in the app"
    )


class MemoryDisplay(Display):
    """A display that keeps a copy of the newest picture in ``picture``."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.picture: Image | None = None

    def _show(self, image: Image) -> None:
        self.picture = image.copy()
