"""From a shot to a frame: the way up, the size and the number that the app is promised."""

from __future__ import annotations

import numpy as np

from drivers.raspberrypi.cameras.settings import CameraSettings
from drivers.raspberrypi.cameras.source import Shot
from robotcore.description import CameraDescription
from robotcore.errors import DeviceError
from robotcore.hal.devices import Frame, Image


class Framing:
    """Turns shots into frames as the camera is described, and numbers them from 0."""

    def __init__(self, told: CameraDescription, settings: CameraSettings) -> None:
        self._told = told
        self._flip = _flip_code(settings)
        self._count = 0

    def frame(self, shot: Shot) -> Frame:
        """Return the next frame; raises DeviceError where the shot shows another field of view than is described."""
        image = np.ascontiguousarray(self._turned(self._sized(shot.image)))
        image.flags.writeable = False
        frame = Frame(image, shot.time, self._count)
        self._count += 1
        return frame

    def _sized(self, image: Image) -> Image:
        told, (height, width) = self._told, image.shape[:2]
        if (width, height) == (told.width_px, told.height_px):
            return image
        if abs(told.width_px * height / width - told.height_px) > 1:
            raise DeviceError(
                told.name,
                f"it gives {width}x{height} px, the robot's description says {told.width_px}x{told.height_px}: "
                "another shape, so another field of view. Set width_px and height_px to a size that the camera has",
            )
        import cv2

        size = (told.width_px, told.height_px)
        return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)

    def _turned(self, image: Image) -> Image:
        if self._flip is None:
            return image
        import cv2

        return np.asarray(cv2.flip(image, self._flip), dtype=np.uint8)


def _flip_code(settings: CameraSettings) -> int | None:
    """Return OpenCV's code: 1 about the vertical axis, 0 about the horizontal one, -1 about both, None about none."""
    is_mirrored = settings.flip_horizontal != settings.rotate_180
    is_on_its_head = settings.flip_vertical != settings.rotate_180
    return {(True, True): -1, (True, False): 1, (False, True): 0}.get((is_mirrored, is_on_its_head))
