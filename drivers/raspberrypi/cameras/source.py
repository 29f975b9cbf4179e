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
    """How a camera is mounted, and how its exposure and its white balance are found.

    With ``lock``, both are held as soon as they have settled, after ``settle_s`` at the latest: a colour that drifts is
    the most common reason why a real robot does not see what it looks for. ``exposure_s`` is set by hand.
    """

    fps: Annotated[float, Field(ge=1, le=240)] = 30.0
    lock: bool = True
    settle_s: Annotated[float, Field(gt=0, le=30)] = 2.0
    exposure_s: Seconds | None = None
    rotate_180: bool = False
    flip_horizontal: bool = False
    flip_vertical: bool = False


Gain = Annotated[float, Field(gt=0, le=32)]
Gains = Annotated[tuple[Gain, Gain], Field(description="[red, blue]")]


class PiCameraSettings(CameraSettings):
    """Which of the Pi's cameras, and what is set by hand: the sensor's gain, and the gains of red and of blue."""

    camera: Annotated[int, Field(ge=0, le=7)] = 0
    gain: Annotated[float, Field(ge=1, le=64)] | None = None
    colour_gains: Gains | None = None


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
    """Which camera, and what is set by hand: the gain in the camera's own unit, the white balance in kelvin.

    A name in ``/dev/v4l/by-id`` stays the camera's own whatever else is plugged in. ``pixel_format`` is V4L2's four
    letters; MJPG lets large pictures through USB at full rate.
    """

    device: Node = "/dev/video0"
    pixel_format: Annotated[str, Field(pattern=r"^[A-Z0-9]{4}$")] | None = None
    gain: Annotated[int, Field(ge=0)] | None = None
    white_balance_k: Annotated[int, Field(ge=1000, le=20000)] | None = None

    @property
    def path(self) -> Path:
        return Path(f"/dev/video{self.device}" if isinstance(self.device, int) else self.device)


class Shot(NamedTuple):
    """A picture as the camera took it: BGR, its moment on the robot's clock, and what the camera tells of it."""

    image: Image
    time: float
    metadata: Mapping[str, Any] = {}


class ExposureState(NamedTuple):
    """How far exposure and white balance have settled.

    ``values`` come to rest then; ``is_found`` is the camera's own word on it, None where it has none.
    """

    values: tuple[float, ...]
    is_settled: bool | None = None


class Source(ABC):
    """A camera that takes pictures one after another; one thread at a time uses it.

    Every method but `close` raises DeviceError by the camera's ``name``.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def open(self) -> list[str]:
        """Let it run, with exposure and white balance by itself where they are not set by hand.

        Return the names of the settings that the camera does not take.
        """

    @abstractmethod
    def shoot(self) -> Shot:
        """Wait for the next picture, but not for ever; the memory is the caller's."""

    @abstractmethod
    def read_exposure(self, shot: Shot) -> ExposureState:
        """Return how far it has settled by a shot."""

    @abstractmethod
    def hold(self, shot: Shot) -> list[str]:
        """Keep exposure and white balance as they are in this shot; return what the camera does not let itself hold."""

    @abstractmethod
    def close(self) -> None:
        """Let the camera go, whatever state it is in; may be called again. Never raises."""


FRESH_S = 1.0
"""A camera's first stamp is not older, where it counts on the kernel's clock."""


class TimestampConverter:
    """Turns stamps in CLOCK_MONOTONIC, in seconds, into the robot's time.

    A camera whose first stamp is not of the last second counts from somewhere else: then the picture's arrival is
    taken, which is later by exposure and transfer, up to two frames. Every later stamp is believed, however old.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._is_trusted: bool | None = None

    def time_of(self, monotonic_s: float) -> float:
        """Return the time of capture, never in the future."""
        now, stamped = self._clock.now(), self._clock.time_of(monotonic_s)
        if self._is_trusted is None:
            self._is_trusted = now - stamped < FRESH_S
        return stamped if self._is_trusted else now
