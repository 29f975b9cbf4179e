"""A camera that takes pictures beside the app, converts them into frames, and reopens after a failure."""

from __future__ import annotations

import logging
import threading

import numpy as np

from drivers.raspberrypi.cameras.exposure import ExposureLock
from drivers.raspberrypi.cameras.settings import CameraSettings
from drivers.raspberrypi.cameras.source import Shot, Source
from robotcore.description import CameraDescription
from robotcore.errors import DeviceError, ResourceError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Camera, Frame, Image
from robotcore.hardware import LatestSample
from robotcore.threads import start_thread

RETRY_S, LONGEST_RETRY_S = 0.5, 2.0
"""A camera that failed is tried again after this long, then after twice as long, up to the longest."""

CLOSING_S = 1.0
"""A camera that hangs does not keep a robot from being closed for longer."""

_log = logging.getLogger(__name__)


class CapturingCamera(Camera):
    """Hands out the newest picture of a source.

    The work that is polled waits for the next picture. It is due twice a frame, so that it waits for the camera and
    no picture for it. Where the source fails, `read` raises why, and it is opened again until that succeeds.
    """

    def __init__(self, description: CameraDescription, settings: CameraSettings, source: Source, clock: Clock) -> None:
        super().__init__(description.name, description.intrinsics)
        self._source, self._clock = source, clock
        self._exposure_lock = ExposureLock(source, settings, clock)
        self._converter = FrameConverter(description, settings)
        self._period = 0.5 / settings.fps
        self._in_use = threading.Lock()
        self._is_running = False
        self._retry_at, self._retry_s = 0.0, RETRY_S

    def open(self) -> None:
        """Wait for the first picture, settled and held; raises DeviceError, and then it is closed again."""
        try:
            first = self._attempt(self._begin)
        except BaseException:
            self._source.close()
            raise
        self._frames = LatestSample(self.name, first)
        self._polling = self._clock.every(self._period, self._poll, f"{self.name}: pictures")

    def _newest(self) -> Frame:
        return self._frames.get()

    def _release(self) -> None:
        self._polling.stop()
        try:
            closing = start_thread(self._close_source, f"{self.name}: closing")
        except ResourceError:
            self._close_source()
            return
        closing.join(CLOSING_S)
        if closing.is_alive():
            _log.warning("%s: the camera hangs; it is let go when it answers, or when the program has ended", self.name)

    def _close_source(self) -> None:
        """Close the source as soon as nobody waits for a picture of it: no library bears that in between."""
        with self._in_use:
            self._source.close()

    def _poll(self) -> None:
        with self._in_use:
            if self._is_closed or (not self._is_running and self._clock.now() < self._retry_at):
                return
            try:
                self._frames.put(self._next() if self._is_running else self._begin())
            except Exception as failure:  # noqa: BLE001  whatever a camera's library raises, `read` tells it
                self._frames.fail(failure)
                self._schedule_retry()

    def _begin(self) -> Frame:
        frame = self._converter.frame(self._exposure_lock.begin())
        self._is_running, self._retry_s = True, RETRY_S
        return frame

    def _next(self) -> Frame:
        return self._converter.frame(self._source.shoot())

    def _schedule_retry(self) -> None:
        self._source.close()
        self._is_running = False
        self._retry_at = self._clock.now() + self._retry_s
        self._retry_s = min(2 * self._retry_s, LONGEST_RETRY_S)


class FrameConverter:
    """Turns shots into frames as the camera is described, and numbers them from 0."""

    def __init__(self, description: CameraDescription, settings: CameraSettings) -> None:
        self._description = description
        self._flip = _flip_code(settings)
        self._count = 0

    def frame(self, shot: Shot) -> Frame:
        """Return the next frame; raises DeviceError where the shot shows another field of view than is described."""
        image = np.ascontiguousarray(self._flip_image(self._resize(shot.image)))
        image.flags.writeable = False
        frame = Frame(image, shot.time, self._count)
        self._count += 1
        return frame

    def _resize(self, image: Image) -> Image:
        description, (height, width) = self._description, image.shape[:2]
        if (width, height) == (description.width_px, description.height_px):
            return image
        if abs(description.width_px * height / width - description.height_px) > 1:
            raise DeviceError(
                description.name,
                f"it gives {width}x{height} px, the robot's description says "
                f"{description.width_px}x{description.height_px}: another shape, so another field of view. "
                "Set width_px and height_px to a size that the camera has",
                kind="camera-shape",
            )
        import cv2

        size = (description.width_px, description.height_px)
        return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)

    def _flip_image(self, image: Image) -> Image:
        if self._flip is None:
            return image
        import cv2

        return np.asarray(cv2.flip(image, self._flip), dtype=np.uint8)


def _flip_code(settings: CameraSettings) -> int | None:
    """Return OpenCV's code: 1 about the vertical axis, 0 about the horizontal one, -1 about both, None about none."""
    is_mirrored = settings.flip_horizontal != settings.rotate_180
    is_on_its_head = settings.flip_vertical != settings.rotate_180
    return {(True, True): -1, (True, False): 1, (False, True): 0}.get((is_mirrored, is_on_its_head))
