"""What an app sees of a robot: motors, sensors and displays, and the samples they give.

A driver fills in the hooks that begin with an underscore; what every device owes its user (limits, the
refusal of a number that is none, errors after closing, closing twice) is done here, once.

SI units: metres, radians, seconds, rad/s. Every sample carries its time of capture on the robot's clock.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, ParamSpec, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from robotcore.asking import asking_line
from robotcore.errors import DeviceClosedError, DeviceError, InvalidCommandError, RobotcoreError
from robotcore.geometry import Pose

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


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A pinhole camera: size in pixels and horizontal field of view in radians.

    Pixel centres have whole coordinates, as in OpenCV, so the axis meets the picture at ``(cx, cy)``.
    """

    width: int
    height: int
    horizontal_fov: float

    @property
    def focal_length(self) -> float:
        """In pixels; pixels are square."""
        return self.width / 2 / math.tan(self.horizontal_fov / 2)

    @property
    def cx(self) -> float:
        return (self.width - 1) / 2

    @property
    def cy(self) -> float:
        return (self.height - 1) / 2

    def bearing(self, u: float) -> float:
        """Return the direction of column ``u`` in radians, positive to the left."""
        return math.atan2(self.cx - u, self.focal_length)


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

    def __init__(self, name: str, max_velocity: float) -> None:
        super().__init__(name)
        self.max_velocity = max_velocity

    def set_velocity(self, rad_s: float) -> float:
        """Turn at ``rad_s``; return the velocity in fact sent, after ``max_velocity``.

        Raises InvalidCommandError, and stops, where ``rad_s`` is NaN or infinite.
        """
        self._require_open()
        if not math.isfinite(rad_s):
            self.stop()
            raise invalid_velocity(self.name, rad_s)
        limit = self.max_velocity
        sent = limit if rad_s > limit else -limit if rad_s < -limit else rad_s  # noqa: FURB136  15 times faster so
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

    @abstractmethod
    def _apply(self, rad_s: float) -> None:
        """Send a finite velocity within the limits."""


class Sensor(Device, ABC, Generic[SampleT]):
    """A device that is read."""

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

    mount = Pose(0.0, 0.0, 0.0)

    def __init__(self, name: str, *, min_range: float, max_range: float, cone: float) -> None:
        super().__init__(name)
        self.min_range, self.max_range, self.cone = min_range, max_range, cone


class Camera(Sensor[Frame]):
    """A picture of what is ahead; ``mount`` as for a range sensor."""

    mount = Pose(0.0, 0.0, 0.0)

    def __init__(self, name: str, intrinsics: Intrinsics) -> None:
        super().__init__(name)
        self.intrinsics = intrinsics


class Encoder(Sensor[Angle]):
    """The angle of a wheel."""


class Battery(Sensor[Voltage]):
    """The voltage of the robot's battery, which nobody drives by: it may be old, or fail, and no run ends for it.

    Below ``warn_below`` volts it is to be charged; a robot's assembly sets it from the description.
    """

    warn_below: float | None = None


class Display(Device, ABC):
    """Where an app shows its annotated picture."""

    def show(self, image: Image) -> None:
        """Show a BGR or grey picture, top-left origin."""
        self._require_open()
        self._attempt(self._show, image)

    @abstractmethod
    def _show(self, image: Image) -> None:
        """Hand a picture on."""


def invalid_velocity(name: str, rad_s: float) -> InvalidCommandError:
    """Return the error for a velocity that is no number, with the line of the app that asked for it."""
    line = asking_line()
    where = f", at {line}" if line else ""
    return InvalidCommandError(
        f"{name}: a velocity of {rad_s} rad/s was asked for{where}; it must be a finite number. "
        "All motors were stopped; look for a division by zero or a range of inf in the app"
    )
