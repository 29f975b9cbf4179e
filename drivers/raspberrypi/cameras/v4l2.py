"""The driver of a camera on USB, or of whatever else V4L2 knows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, Field

from drivers.raspberrypi.cameras.capturing import CapturingCamera
from drivers.raspberrypi.cameras.settings import CameraSettings
from robotcore.description import CameraDescription
from robotcore.hardware import Connection, DeviceDriver, Host


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


class UsbCamera(DeviceDriver[CameraDescription, UsbCameraSettings]):
    """Opens cameras by OpenCV on V4L2."""

    name = "v4l2"
    summary = "a camera on USB"
    described = CameraDescription
    settings = UsbCameraSettings
    modules = ("cv2",)
    remedy = "pip install opencv-python-headless"

    def open(self, told: CameraDescription, settings: UsbCameraSettings, host: Host) -> CapturingCamera:
        from drivers.raspberrypi.cameras.usb import UsbSource

        camera = CapturingCamera(told, settings, UsbSource(told, settings, host.clock), host.clock)
        camera.open()
        return camera

    def connections(self, settings: UsbCameraSettings) -> Sequence[Connection]:
        return (Connection("camera", "USB", str(settings.path)),)
