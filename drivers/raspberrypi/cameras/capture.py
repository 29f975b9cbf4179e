"""The capture of pictures in the background: lock the exposure, convert pictures to frames, reopen a failed camera."""

from __future__ import annotations

import logging
import math
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np
from pydantic import Field

from robotcore.errors import DeviceError, ResourceError
from robotcore.hal.clock import Clock
from robotcore.hal.device_test import FLIPPED_HORIZONTALLY, FLIPPED_VERTICALLY, RED_AND_BLUE_SWAPPED, ROTATED_180
from robotcore.hardware import DeviceContext, DeviceDriver, NewestSample
from robotcore.kinds.camera import Camera, CameraDescription, Frame
from robotcore.optics import Image
from robotcore.threads import start_thread

Seconds = Annotated[float, Field(gt=0, le=1)]


class Shot(NamedTuple):
    """A picture from a camera."""

    image: Image
    """The pixels (blue, green, red) with the camera's own size and orientation."""

    time: float
    """The time of capture on the robot's clock, in seconds."""

    metadata: Mapping[str, Any] = {}
    """The camera's data about this picture, such as picamera2's metadata."""


SettingsT = TypeVar("SettingsT", bound="CameraDriver")


class Source(ABC, Generic[SettingsT]):
    """The interface to the library of a camera. Only one thread at a time may use a source.

    Every method except `close` may raise DeviceError.
    """

    def __init__(self, description: CameraDescription, settings: SettingsT, clock: Clock) -> None:
        self.name, self.description, self.settings, self.clock = description.name, description, settings, clock

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
    def read_exposure(self, shot: Shot) -> Sequence[float]:
        """Return the exposure and the white balance of a picture, such as the product of exposure and gain.

        The numbers are constant when exposure and white balance have settled.
        """

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


STEADY_SHOTS = 10
"""Exposure has settled if it is constant in this many pictures in a row. Cameras react faster to a change of light."""

STEADY_RATIO = 1.03
"""Values count as constant if the largest is at most this many times the smallest. Noise changes them much less."""

DARK = 4.0
"""The number that is added to a brightness (0 to 255) before a ratio is computed, because dark pictures have noise."""

FRAMES_IN_FLIGHT = 8
"""The number of pictures after a change of the exposure that may still have the old exposure.

Source: https://github.com/raspberrypi/libcamera, src/ipa/rpi: two frames of delay; picamera2: six buffers."""

BRIGHTNESS_TOLERANCE = 1.25
"""If locking changes the brightness by more than this factor, the camera has locked wrong values."""

_log = logging.getLogger(__name__)


class ExposureLock:
    """Opens a camera's source, waits until the exposure has settled, and locks the exposure.

    Each problem is logged only once, although the source may be opened several times.
    """

    def __init__(self, source: Source[Any]) -> None:
        self._source, self._settings, self._clock = source, source.settings, source.clock
        self._warned: set[str] = set()

    def begin(self) -> Shot:
        """Open the source, and return its first picture, with locked exposure if the setting ``lock`` is true."""
        if rejected := self._source.open():
            self._warn(f"does not accept {', '.join(rejected)}; remove it from the robot's file")
        shot = self._source.shoot()
        return self._lock(self._settle(shot)) if self._settings.lock else shot

    def _settle(self, shot: Shot) -> Shot:
        until = self._clock.now() + self._settings.settle_s
        states: deque[Sequence[float]] = deque(maxlen=STEADY_SHOTS)
        for _ in range(math.ceil(self._settings.settle_s * self._settings.fps)):
            states.append(self._source.read_exposure(shot))
            if _is_steady(states) or self._clock.now() >= until:
                break
            shot = self._source.shoot()
        return shot

    def _lock(self, before: Shot) -> Shot:
        refused = self._source.lock_exposure(before)
        for _ in range(FRAMES_IN_FLIGHT):
            after = self._source.shoot()
        if refused:
            self._warn(f"cannot lock its {' and '.join(refused)}; colours may drift as the robot drives")
        change = (after.image.mean() + DARK) / (before.image.mean() + DARK)
        if not 1 / BRIGHTNESS_TOLERANCE < change < BRIGHTNESS_TOLERANCE:
            self._warn(
                f"became {change:.1f} times as bright when its exposure was locked; set exposure_s, or lock = false"
            )
        return after

    def _warn(self, message: str) -> None:
        if message not in self._warned:
            self._warned.add(message)
            _log.warning("%s: %s", self._source.name, message)


def _is_steady(states: Sequence[Sequence[float]]) -> bool:
    series = zip(*states, strict=True)
    return len(states) == STEADY_SHOTS and all(max(values) <= STEADY_RATIO * min(values) for values in series)


RETRY_S, LONGEST_RETRY_S = 0.5, 2.0
"""The first and the longest wait before a failed camera is opened again, in seconds. The wait doubles each time."""

CLOSING_S = 1.0
"""The longest wait for the closing of a camera that hangs, in seconds."""


class CapturingCamera(Camera):
    """A camera that returns the newest picture of a source.

    A background task waits for each picture. It runs twice as often as pictures arrive, so that they do not queue up.
    If the source fails, `read` raises the error, and the task opens the source again as soon as possible.
    """

    def __init__(self, source: Source[Any]) -> None:
        super().__init__(source.name, source.description.intrinsics)
        self._source, self._clock = source, source.clock
        self._exposure_lock = ExposureLock(source)
        self._converter = FrameConverter(source.description, source.settings)
        self._in_use = threading.Lock()
        self._is_running = False
        self._retry_at, self._retry_s = 0.0, RETRY_S

    def open(self) -> None:
        """Open the camera, and wait for its first picture; close the camera and raise DeviceError if that fails."""
        try:
            first = self._attempt(self._open_source)
        except BaseException:
            self._source.close()
            raise
        self._frames = NewestSample(self.name, first)
        self._polling = self._clock.call_every(0.5 / self._source.settings.fps, self._poll, f"{self.name}: pictures")

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
            _log.warning(
                "%s: the camera hangs; it will be closed when it responds, or when the program ends", self.name
            )

    def _close_source(self) -> None:
        with self._in_use:  # closing a source during a capture crashes the camera's library
            self._source.close()

    def _poll(self) -> None:
        with self._in_use:
            if self._is_closed or (not self._is_running and self._clock.now() < self._retry_at):
                return
            try:
                frame = self._converter.convert(self._source.shoot()) if self._is_running else self._open_source()
                self._frames.put(frame)
            except Exception as failure:  # noqa: BLE001  `read` raises every error of the library
                self._frames.fail(failure)
                self._source.close()
                self._is_running = False
                self._retry_at = self._clock.now() + self._retry_s
                self._retry_s = min(2 * self._retry_s, LONGEST_RETRY_S)

    def _open_source(self) -> Frame:
        frame = self._converter.convert(self._exposure_lock.begin())
        self._is_running, self._retry_s = True, RETRY_S
        return frame


class FrameConverter:
    """Converts pictures to frames with the size and the orientation of the description, numbered from 0."""

    def __init__(self, description: CameraDescription, settings: CameraDriver) -> None:
        self._description = description
        self._parts = tuple(slice(None, None, -1 if is_reversed else 1) for is_reversed in settings.transformation)
        self._count = 0

    def convert(self, shot: Shot) -> Frame:
        """Return a picture as the next frame; raises DeviceError if its aspect ratio differs from the description's."""
        image = np.ascontiguousarray(self._resize(shot.image)[self._parts])
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
                f"its pictures have {width}x{height} px, and the robot's description has "
                f"{description.width_px}x{description.height_px}: another aspect ratio, so another field of view. "
                "Set width_px and height_px to a size that the camera has",
                kind="camera-shape",
            )
        import cv2

        size = (description.width_px, description.height_px)
        return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


CORRECTED_BY = {
    FLIPPED_HORIZONTALLY: "flip_horizontal",
    FLIPPED_VERTICALLY: "flip_vertical",
    ROTATED_180: "rotate_180",
    RED_AND_BLUE_SWAPPED: "swap_red_blue",
}
"""The setting that corrects each mistake of a camera."""


class CameraDriver(DeviceDriver):
    """The base class of the drivers of cameras. Its settings are the mounting, the exposure and the white balance."""

    described = CameraDescription
    source: ClassVar[type[Source[Any]]]

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

    swap_red_blue: bool = False
    """Whether the camera gives red in place of blue."""

    @property
    def transformation(self) -> tuple[bool, bool, bool]:
        """Whether the rows, the columns and the colours of the camera's pictures are reversed."""
        return self.flip_vertical != self.rotate_180, self.flip_horizontal != self.rotate_180, self.swap_red_blue

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        key = CORRECTED_BY.get(mistake)
        return {key: not getattr(self, key)} if key else None

    def open(self, description: CameraDescription, context: DeviceContext) -> CapturingCamera:
        camera = CapturingCamera(self.source(description, self, context.clock))
        camera.open()
        return camera
