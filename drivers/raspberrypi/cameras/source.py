"""The settings of a camera, and the interface to a camera's own library."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import AfterValidator, Field

from robotcore.description import StrictModel
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Image

Seconds = Annotated[float, Field(gt=0, le=1)]


class CameraSettings(StrictModel):
    """The mounting, the exposure and the white balance of a camera."""

    fps: Annotated[float, Field(ge=1, le=240)] = 30.0
    """The number of pictures a second."""

    lock: bool = True
    """Whether exposure and white balance are locked when they have settled. Programs miss targets if colours drift."""

    settle_s: Annotated[float, Field(gt=0, le=30)] = 2.0
    """The longest wait for exposure and white balance to settle, in seconds. After this time they are locked anyway."""

    exposure_s: Seconds | None = None
    """A fixed exposure time in seconds; None means automatic."""

    rotate_180: bool = False
    """Whether the camera is mounted upside down."""

    flip_horizontal: bool = False
    flip_vertical: bool = False


Gain = Annotated[float, Field(gt=0, le=32)]
Gains = Annotated[tuple[Gain, Gain], Field(description="[red, blue]")]


class PiCameraSettings(CameraSettings):
    """The settings of a camera on the Pi's connector."""

    camera: Annotated[int, Field(ge=0, le=7)] = 0
    """The number of the camera in the list of ``rpicam-hello --list-cameras``."""

    gain: Annotated[float, Field(ge=1, le=64)] | None = None
    """A fixed gain of the sensor; None means automatic."""

    colour_gains: Gains | None = None
    """The gains of red and blue, for a fixed white balance. None means automatic."""


def _path(device: str | int) -> str | int:
    if isinstance(device, str) and not device.startswith("/dev/"):
        raise ValueError(f"{device[:40]!r} is no device; write /dev/video0, a name in /dev/v4l/by-id, or a number")
    return device


Node = Annotated[
    Annotated[int, Field(ge=0, le=255)] | str,
    AfterValidator(_path),
    Field(description='"/dev/video0", "/dev/v4l/by-id/…" or a number'),
]


class UsbCameraSettings(CameraSettings):
    """The settings of a camera on USB."""

    device: Node = "/dev/video0"
    """The camera's device file, or the number N of /dev/videoN. A name in ``/dev/v4l/by-id`` never changes."""

    pixel_format: Annotated[str, Field(pattern=r"^[A-Z0-9]{4}$")] | None = None
    """V4L2's name of the pixel format, four characters. MJPG is compressed, so large pictures have the full rate."""

    gain: Annotated[int, Field(ge=0)] | None = None
    """A fixed gain in the camera's own unit; None means automatic."""

    white_balance_k: Annotated[int, Field(ge=1000, le=20000)] | None = None
    """A fixed white balance in kelvin; None means automatic."""

    @property
    def path(self) -> Path:
        return Path(f"/dev/video{self.device}" if isinstance(self.device, int) else self.device)


class Shot(NamedTuple):
    """A picture from a camera."""

    image: Image
    """The pixels (blue, green, red) with the camera's own size and orientation."""

    time: float
    """The time of capture on the robot's clock, in seconds."""

    metadata: Mapping[str, Any] = {}
    """The camera's data about this picture, such as picamera2's metadata."""


class ExposureState(NamedTuple):
    """The exposure and the white balance of a picture."""

    values: tuple[float, ...]
    """Numbers such as the product of exposure and gain, or colour gains. They are constant when exposure and white
    balance have settled."""

    is_settled: bool | None = None
    """Whether the camera reports that the exposure has settled; None if the camera does not report it."""


class Source(ABC):
    """The interface to the library of a camera. Only one thread at a time may use a source.

    Every method except `close` may raise DeviceError. ``name`` is the camera's name, for errors.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def open(self) -> list[str]:
        """Start the camera; return the names of the settings that the camera does not accept.

        Exposure and white balance are automatic unless the settings fix them.
        """

    @abstractmethod
    def shoot(self) -> Shot:
        """Wait for the next picture and return it; raises DeviceError after a time limit.

        Later pictures do not overwrite its pixels.
        """

    @abstractmethod
    def read_exposure(self, shot: Shot) -> ExposureState:
        """Return the exposure and the white balance of a picture."""

    @abstractmethod
    def lock_exposure(self, shot: Shot) -> list[str]:
        """Lock exposure and white balance at the values of a picture; return the names of what the camera cannot lock.

        The names are ``exposure``, ``gain`` and ``white balance``.
        """

    @abstractmethod
    def close(self) -> None:
        """Close the camera. May be called in any state, and again. Never raises."""


MAX_FIRST_AGE_S = 1.0
"""If a camera's first timestamp is older than this many seconds, the camera does not use CLOCK_MONOTONIC."""


class TimestampConverter:
    """Converts a camera's timestamps on CLOCK_MONOTONIC, in seconds, to times on the robot's clock.

    If the first timestamp is older than `MAX_FIRST_AGE_S`, the camera uses another clock. Then its timestamps are
    ignored, and each picture gets the time of its arrival, up to two frame periods after the capture.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._is_trusted: bool | None = None

    def time_of(self, monotonic_s: float) -> float:
        """Return a timestamp in seconds on the robot's clock. The result is never in the future."""
        now, stamped = self._clock.now(), self._clock.time_of(monotonic_s)
        if self._is_trusted is None:
            self._is_trusted = now - stamped < MAX_FIRST_AGE_S
        return stamped if self._is_trusted else now
