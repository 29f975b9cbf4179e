"""The driver of a camera on the Pi's ribbon connector."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.raspberrypi.cameras.capturing import CapturingCamera
from drivers.raspberrypi.cameras.csicameras import REMEDY
from drivers.raspberrypi.cameras.settings import PiCameraSettings
from robotcore.description import CameraDescription
from robotcore.hardware import Connection, DeviceDriver, Host


class PiCamera(DeviceDriver[CameraDescription, PiCameraSettings]):
    """Opens cameras by picamera2, which Raspberry Pi OS brings: 0.3.20 or newer."""

    name = "picamera2"
    summary = "a camera on the Pi's ribbon connector"
    described = CameraDescription
    settings = PiCameraSettings
    parts = ("pi-camera", "csi", "libcamera", "camera-module")
    modules = ("picamera2",)
    remedy = REMEDY

    def open(self, told: CameraDescription, settings: PiCameraSettings, host: Host) -> CapturingCamera:
        from drivers.raspberrypi.cameras.csi import CsiSource

        camera = CapturingCamera(told, settings, CsiSource(told, settings, host.clock), host.clock)
        camera.open()
        return camera

    def connections(self, settings: PiCameraSettings) -> Sequence[Connection]:
        return (Connection("camera", "CSI", str(settings.camera)),)
