"""The driver of cameras on USB, and of other cameras that V4L2 supports, the kernel's camera interface."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import cv2
import numpy as np
from pydantic import AfterValidator, Field

from drivers.raspberrypi.cameras.capture import (
    CameraDriver,
    Shot,
    Source,
    TimestampConverter,
)
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hardware import Connection


def _path(device: str | int) -> str | int:
    if isinstance(device, str) and not device.startswith("/dev/"):
        raise ValueError(f"{device[:40]!r} is no device; write /dev/video0, a name in /dev/v4l/by-id, or a number")
    return device


Node = Annotated[
    Annotated[int, Field(ge=0, le=255)] | str,
    AfterValidator(_path),
    Field(description='"/dev/video0", "/dev/v4l/by-id/…" or a number'),
]


NODES = Path("/sys/class/video4linux")
"""The folder with the kernel's data on each /dev/video file: its name, its index within the camera, and a link to the
camera. Source: https://www.kernel.org/doc/html/latest/driver-api/media/v4l2-dev.html."""


def list_usb_cameras() -> list[str]:
    """Return the file and the name of each camera on USB, such as ``/dev/video0 (HD Webcam)``.

    Files that deliver no pictures are left out: a camera's further files, and those of the Pi's video codecs.
    """
    nodes = sorted(NODES.glob("video*"), key=lambda node: int(node.name.removeprefix("video")))
    return [
        f"/dev/{node.name} ({(node / 'name').read_text().strip()})"
        for node in nodes
        if "/usb" in str((node / "device").resolve()) and (node / "index").read_text().strip() == "0"
    ]


AUTO, MANUAL, APERTURE_PRIORITY = 0, 1, 3
"""Values of the control V4L2_CID_EXPOSURE_AUTO. A webcam's automatic mode is aperture priority, because its aperture is
fixed."""

EXPOSURE_UNIT_S = 100e-6
"""The unit of the control V4L2_CID_EXPOSURE_ABSOLUTE, in seconds."""

_NO_CAMERA = "There is no camera on USB: plug it in, and check lsusb"

BUFFERS = 2
"""The number of picture buffers. The camera fills one while the other waits to be read. More buffers delay pictures."""

BROKEN_IN_A_ROW = 5
"""The camera has failed after this many broken pictures in a row. Cheap cables and starting cameras cause a few."""


class UsbSource(Source["UsbCamera"]):
    """Takes pictures from a USB camera by OpenCV.

    The time of a picture is the kernel's timestamp of the arrival of its first bytes, right after the exposure. It is
    accurate to a millisecond.

    After the camera was open once, every failure raises DeviceLostError, because the camera may be unplugged. The state
    of its file does not show this: the file may still exist right after unplugging, and belongs to root right after
    plugging in.
    """

    _capture: Any = None
    _was_there = False

    def open(self) -> list[str]:
        path = self.settings.path
        self._require_file()
        if cv2.CAP_V4L2 not in cv2.videoio_registry.getCameraBackends():
            raise DeviceError(
                self.name, "this OpenCV is built without V4L2. Run pip install opencv-python-headless", kind="no-v4l2"
            )
        self._capture = capture = cv2.VideoCapture(str(path), cv2.CAP_V4L2)
        if not capture.isOpened():
            raise self._build_error(
                f"{path} cannot be opened as a camera. End any other program that uses it (fuser {path}). "
                "List cameras: v4l2-ctl --list-devices"
            )
        self._was_there = True
        self._stamps = TimestampConverter(self.clock)
        self._request_format(capture)
        return self._apply_settings()

    def shoot(self) -> Shot:
        for _ in range(BROKEN_IN_A_ROW):
            if not self._capture.grab():
                break
            time = self._stamps.time_of(self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000)
            is_whole, image = self._capture.retrieve()
            if is_whole:
                return Shot(np.asarray(image, dtype=np.uint8), time)
        self._require_file()
        raise self._build_error(f"{self.settings.path} gives no more pictures. Check its plug and its cable")

    def read_exposure(self, shot: Shot) -> Sequence[float]:
        return cv2.mean(shot.image)[:3]

    def lock_exposure(self, shot: Shot) -> list[str]:
        exposure = self._capture.get(cv2.CAP_PROP_EXPOSURE)
        kelvin = self._capture.get(cv2.CAP_PROP_WB_TEMPERATURE)
        held = {
            "exposure": exposure > 0 and self._set_exposure(exposure),
            "white balance": kelvin > 0 and self._set_white_balance(kelvin),
        }
        return [name for name, is_held in held.items() if not is_held]

    def close(self) -> None:
        capture, self._capture = self._capture, None
        if capture is not None:
            capture.release()

    def _require_file(self) -> None:
        path = self.settings.path
        if not path.exists():
            if self._was_there:
                raise self._build_error(f"{path} is gone; plug it in again")
            cameras = list_usb_cameras()
            found = f"There are: {', '.join(cameras)}" if cameras else _NO_CAMERA
            raise self._build_error(f"there is no {path}. {found}")
        if not os.access(path, os.R_OK | os.W_OK):
            raise self._build_error(
                f"no permission for {path}. Run sudo usermod -aG video $USER, then log out and in again"
            )

    def _build_error(self, message: str) -> DeviceError:
        return (DeviceLostError if self._was_there else DeviceError)(self.name, message)

    def _request_format(self, capture: cv2.VideoCapture) -> None:
        # V4L2 sets the nearest format, size and frame rate that the camera supports.
        if self.settings.pixel_format:
            capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*self.settings.pixel_format))
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, self.description.width_px)
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, self.description.height_px)
        capture.set(cv2.CAP_PROP_FPS, self.settings.fps)
        capture.set(cv2.CAP_PROP_BUFFERSIZE, BUFFERS)

    def _apply_settings(self) -> list[str]:
        settings, accepted = self.settings, {}
        if settings.exposure_s is None:
            self._set(cv2.CAP_PROP_AUTO_EXPOSURE, APERTURE_PRIORITY) or self._set(cv2.CAP_PROP_AUTO_EXPOSURE, AUTO)
        else:
            accepted["exposure_s"] = self._set_exposure(max(1, round(settings.exposure_s / EXPOSURE_UNIT_S)))
        if settings.white_balance_k is None:
            self._set(cv2.CAP_PROP_AUTO_WB, 1)
        else:
            accepted["white_balance_k"] = self._set_white_balance(settings.white_balance_k)
        if settings.gain is not None:
            accepted["gain"] = self._set(cv2.CAP_PROP_GAIN, settings.gain)
        return [name for name, is_accepted in accepted.items() if not is_accepted]

    def _set_exposure(self, units: float) -> bool:
        return self._set(cv2.CAP_PROP_AUTO_EXPOSURE, MANUAL) and self._set(cv2.CAP_PROP_EXPOSURE, units)

    def _set_white_balance(self, kelvin: float) -> bool:
        return self._set(cv2.CAP_PROP_AUTO_WB, 0) and self._set(cv2.CAP_PROP_WB_TEMPERATURE, kelvin)

    def _set(self, control: int, value: float) -> bool:
        return bool(self._capture.set(control, value))


class UsbCamera(CameraDriver):
    """Opens cameras by OpenCV and V4L2."""

    name = "v4l2"
    summary = "a camera on USB"
    source = UsbSource
    aliases = ("usb", "webcam", "uvc")
    modules = ("cv2",)
    remedy = "pip install opencv-python-headless"

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

    def connections(self) -> Sequence[Connection]:
        return (Connection("camera", "USB", str(self.path)),)
