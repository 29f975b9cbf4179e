"""The driver of cameras on USB, and of other cameras that V4L2 supports."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.raspberrypi.cameras.capture import CapturingCamera
from drivers.raspberrypi.cameras.source import UsbCameraSettings
from robotcore.description import CameraDescription
from robotcore.hardware import Connection, DeviceDriver, Host


class UsbCamera(DeviceDriver[CameraDescription, UsbCameraSettings]):
    """Opens cameras by OpenCV and V4L2."""

    name = "v4l2"
    summary = "a camera on USB"
    described = CameraDescription
    settings = UsbCameraSettings
    aliases = ("usb", "webcam", "uvc")
    modules = ("cv2",)
    remedy = "pip install opencv-python-headless"

    def open(self, description: CameraDescription, settings: UsbCameraSettings, host: Host) -> CapturingCamera:
        from drivers.raspberrypi.cameras.usb_source import UsbSource

        camera = CapturingCamera(description, settings, UsbSource(description, settings, host.clock), host.clock)
        camera.open()
        return camera

    def connections(self, settings: UsbCameraSettings) -> Sequence[Connection]:
        return (Connection("camera", "USB", str(settings.path)),)
