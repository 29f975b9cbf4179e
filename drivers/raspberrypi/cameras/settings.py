"""Settings of cameras in a robot's file: of any camera, of one on the Pi's connector, of one on USB."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, Field

from robotcore.description import StrictModel

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
