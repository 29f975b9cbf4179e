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
    """Pictures a second."""

    lock: bool = True
    """Lock exposure and white balance when they have settled. With drifting colours, programs often miss targets."""

    settle_s: Annotated[float, Field(gt=0, le=30)] = 2.0
    """Lock exposure and white balance after this many seconds even if they have not settled."""

    exposure_s: Seconds | None = None
    """A fixed exposure time in seconds; None means automatic."""

    rotate_180: bool = False
    """The camera is mounted upside down."""

    flip_horizontal: bool = False
    flip_vertical: bool = False


Gain = Annotated[float, Field(gt=0, le=32)]
Gains = Annotated[tuple[Gain, Gain], Field(description="[red, blue]")]


class PiCameraSettings(CameraSettings):
    """The settings of a camera on the Pi's connector."""

    camera: Annotated[int, Field(ge=0, le=7)] = 0
    """The number of the camera, as ``rpicam-hello --list-cameras`` prints it."""

    gain: Annotated[float, Field(ge=1, le=64)] | None = None
    """A fixed gain of the sensor; None means automatic."""

    colour_gains: Gains | None = None
    """A fixed white balance: the gains of red and of blue; None means automatic."""


def _path(device: str | int) -> str | int:
    if isinstance(device, str) and not device.startswith("/dev/"):
        raise ValueError(f"{device[:40]!r} is no device; take /dev/video0, a name in /dev/v4l/by-id, or a number")
    return device


Node = Annotated[
    Annotated[int, Field(ge=0, le=255)] | str,
    AfterValidator(_path),
    Field(description='"/dev/video0", "/dev/v4l/by-id/…" or a number'),
]


class UsbCameraSettings(CameraSettings):
    """The settings of a camera on USB."""

    device: Node = "/dev/video0"
    """The camera's device file. A name in ``/dev/v4l/by-id`` stays the same if other cameras are plugged in."""

    pixel_format: Annotated[str, Field(pattern=r"^[A-Z0-9]{4}$")] | None = None
    """V4L2's name of the format, four characters. With MJPG, USB can carry large pictures at full rate."""

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
    """The pixels (blue, green, red), before they are scaled and rotated to the robot's description."""

    time: float
    """The time of capture on the robot's clock, in seconds."""

    metadata: Mapping[str, Any] = {}
    """The camera's data about this picture, such as picamera2's metadata."""


class ExposureState(NamedTuple):
    """The state of exposure and white balance in a picture."""

    values: tuple[float, ...]
    """Numbers, such as exposure or colour gains, that are constant when exposure and white balance have settled."""

    is_settled: bool | None = None
    """Whether the camera reports that exposure and white balance have settled; None if it does not report this."""


class Source(ABC):
    """The interface to a camera's library. Only one thread at a time may use a source.

    Every method except `close` raises DeviceError with the camera's ``name``.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def open(self) -> list[str]:
        """Start the camera, with automatic exposure and white balance unless the settings fix them.

        Return the names of the settings that the camera does not accept.
        """

    @abstractmethod
    def shoot(self) -> Shot:
        """Wait for the next picture, up to a time limit, and return it. Later pictures do not overwrite its pixels."""

    @abstractmethod
    def read_exposure(self, shot: Shot) -> ExposureState:
        """Return the state of exposure and white balance in a picture."""

    @abstractmethod
    def hold(self, shot: Shot) -> list[str]:
        """Lock exposure and white balance as in this picture; return the names of those that the camera cannot lock."""

    @abstractmethod
    def close(self) -> None:
        """Close the camera. May be called in any state, and again. Never raises."""


FRESH_S = 1.0
"""If a camera's first timestamp is older than this many seconds, the camera does not use CLOCK_MONOTONIC."""


class TimestampConverter:
    """Converts a camera's timestamps on CLOCK_MONOTONIC, in seconds, to times on the robot's clock.

    If the first timestamp is older than a second, the camera uses another clock, and no timestamp of it is used. Each
    picture then gets the time of its arrival, which is up to two frame periods later than the capture.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._is_trusted: bool | None = None

    def time_of(self, monotonic_s: float) -> float:
        """Return the time of capture on the robot's clock; it is never in the future."""
        now, stamped = self._clock.now(), self._clock.time_of(monotonic_s)
        if self._is_trusted is None:
            self._is_trusted = now - stamped < FRESH_S
        return stamped if self._is_trusted else now
