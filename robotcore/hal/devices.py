"""The base classes of motors, sensors and displays, and the samples of sensors."""

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
"""The module that calls apps. The stack frames above this module are not part of an app."""


def caller_location() -> str:
    """Return ``file.py:line`` of the app's code that called the framework; ``""`` if no app made the call."""
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
    """The fields of every sample."""

    @property
    def time(self) -> float:
        """The time of the measurement on the robot's clock, in seconds."""

    @property
    def sequence(self) -> int:
        """The number of the sample. It grows with each new sample of a device."""


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
    """The distance in metres; ``inf`` if nothing is in range."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""
    point: tuple[float, float, float] | None = None
    """The detected point in the sensor's frame, in metres. Only some simulators provide it."""


@dataclass(frozen=True, slots=True)
class Angle:
    """A sample of an encoder."""

    angle: float
    """The angle by which the wheel has turned since the robot was opened, in radians, positive forward."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""


@dataclass(frozen=True, slots=True)
class Voltage:
    """A sample of a battery."""

    voltage: float
    """The voltage of the battery, in volts."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""


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
    """The time of capture on the robot's clock, in seconds."""
    sequence: int
    """The number of the frame. It grows with each new frame of a camera."""

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
    """The base class of a robot's devices. The constructor does not use hardware."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._is_closed = False

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name!r}{', closed' if self._is_closed else ''}>"

    def close(self) -> None:
        """Release the hardware. Then a second `close` does nothing, and other methods raise DeviceClosedError."""
        if not self._is_closed:
            self._is_closed = True
            self._attempt(self._release)

    def _release(self) -> None:
        """Release the hardware. `close` calls this once."""

    def _require_open(self) -> None:
        if self._is_closed:
            raise DeviceClosedError(self.name)

    def _attempt(self, method: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a driver's method. Raise its exceptions, except RobotcoreErrors, as DeviceErrors."""
        try:
            return method(*args, **kwargs)
        except RobotcoreError:
            raise
        except Exception as error:
            raise build_driver_error(self.name, error) from error


class Motor(Device, ABC):
    """A motor of a wheel. A positive velocity drives the robot forward, on the left and on the right.

    ``max_velocity`` is the greatest velocity in rad/s, forward and backward.
    """

    def __init__(self, name: str, max_velocity: float) -> None:
        super().__init__(name)
        self.max_velocity = max_velocity

    def set_velocity(self, rad_s: float) -> float:
        """Send a velocity in rad/s, limited to ``max_velocity``, and return the velocity that was sent.

        It does not wait for hardware.

        Stops the motor and raises InvalidCommandError if ``rad_s`` is NaN or infinite. Raises DeviceError if the motor
        fails.
        """
        self._require_open()
        if not math.isfinite(rad_s):
            self.stop()
            raise invalid_velocity(self.name, rad_s)
        sent = max(-self.max_velocity, min(rad_s, self.max_velocity))
        self._attempt(self._apply, sent)
        return sent

    def stop(self) -> None:
        """Stop the motor now. A closed motor is stopped already."""
        if not self._is_closed:
            self._attempt(self._apply, 0.0)

    def close(self) -> None:
        """Stop the motor, then release the hardware, even if the stop has failed."""
        try:
            self.stop()
        finally:
            super().close()

    @abstractmethod
    def _apply(self, rad_s: float) -> None:
        """Send a velocity in rad/s, which is finite and at most ``max_velocity``, without waiting for the hardware.

        A driver of slow hardware stores the velocity, and a thread of the driver sends it.
        """


class VelocityOutput(Protocol):
    """The methods of a motor that layers of a run, such as a fault, can replace."""

    @property
    def name(self) -> str:
        """The motor's name."""

    def set_velocity(self, rad_s: float, /) -> float:
        """Send a velocity in rad/s, and return the velocity that was sent."""

    def stop(self) -> None:
        """Stop the motor."""


class Sensor(Device, ABC, Generic[SampleT]):
    """The base class of sensors, which return samples."""

    def read(self) -> SampleT:
        """Return the newest sample, without waiting for hardware. Raises DeviceError if the sensor fails."""
        self._require_open()
        return self._attempt(self._newest)

    @abstractmethod
    def _newest(self) -> SampleT:
        """Return the newest sample. Without a new measurement, return the last sample with its old time.

        An implementation raises an exception if the sensor fails, and never returns a made-up value.
        """


class RangeSensor(Sensor[Range]):
    """A sensor that measures the distance to the nearest body in a cone, such as an ultrasonic module.

    min_range, max_range: the shortest and the longest distance that the sensor measures, in metres. A shorter distance
        is returned as ``min_range``.
    cone: the full opening angle of the cone in radians.

    ``mount`` is the sensor's pose on the robot in the plane. A run sets it from the robot's description.
    """

    mount = Pose(0.0, 0.0, 0.0)

    def __init__(self, name: str, *, min_range: float, max_range: float, cone: float) -> None:
        super().__init__(name)
        self.min_range, self.max_range, self.cone = min_range, max_range, cone


class Camera(Sensor[Frame]):
    """A camera. ``intrinsics`` is its pinhole model, and ``mount`` is its pose on the robot in the plane."""

    mount = Pose(0.0, 0.0, 0.0)

    def __init__(self, name: str, intrinsics: Intrinsics) -> None:
        super().__init__(name)
        self.intrinsics = intrinsics


class Encoder(Sensor[Angle]):
    """A sensor that measures the angle of a wheel."""


class Battery(Sensor[Voltage]):
    """A sensor that measures the voltage of a battery. A run continues if this sensor fails.

    A run warns below ``warn_below`` volts, a limit that the run sets from the robot's description.
    """

    warn_below: float | None = None


SENSOR_KINDS = (Camera, RangeSensor, Encoder, Battery)
"""The base classes of sensors. Each sensor of a driver inherits one of them."""


class Display(Device, ABC):
    """A device that shows the pictures of an app."""

    def show(self, image: Image) -> None:
        """Show a BGR or a grey picture. Raises DeviceError if the display fails."""
        self._require_open()
        self._attempt(self._show, image)

    @abstractmethod
    def _show(self, image: Image) -> None:
        """Show a BGR or a grey picture on the hardware."""


def build_driver_error(device: str, error: Exception, kind: str = "driver-error") -> DeviceError:
    """Return the error for an exception of a driver. The caller raises it from that exception."""
    return DeviceError(device, f"{type(error).__name__}: {error}".removesuffix(": "), kind=kind)


def invalid_velocity(name: str, rad_s: float) -> InvalidCommandError:
    """Return the error for a command that is NaN or infinite. Its message names the app's line that gave the command.

    name: the name of the motor.
    rad_s: the commanded velocity.
    """
    line = caller_location()
    where = f", at {line}" if line else ""
    return InvalidCommandError(
        f"{name}: the app commanded a velocity of {rad_s} rad/s{where}, and all motors were stopped. "
        "Look for a division by zero, or for a range of inf, in the app"
    )


class MemoryDisplay(Display):
    """A display that keeps a copy of the newest picture in ``picture``."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.picture: Image | None = None

    def _show(self, image: Image) -> None:
        self.picture = image.copy()
