"""Doubles for the tests of cameras: a clock with kernel stamps, a source, and OpenCV's capture of a webcam."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from drivers.raspberrypi.cameras.capture import CameraDriver, CapturingCamera, Shot, Source
from robotcore.description import load_robot
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.kinds.camera import CameraDescription
from robotcore.optics import Image

BOOTED_S = 5000.0
"""The value of CLOCK_MONOTONIC when the clock begins, in seconds."""

FOUND = load_robot("rover").first_of(CameraDescription)
assert FOUND
EYE = FOUND.model_copy(update={"width_px": 32, "height_px": 24})

RED_RGB = (200, 40, 30)
RED_BGR = RED_RGB[::-1]


class LabClock(SteppedClock):
    """A stepped clock that also converts the kernel's timestamps."""

    def __init__(self) -> None:
        super().__init__(20, lambda _steps: None)

    @property
    def monotonic_s(self) -> float:
        return BOOTED_S + self.now()

    def time_of(self, monotonic_s: float) -> float:
        return min(monotonic_s - BOOTED_S, self.now())

    def pass_time(self, seconds: float) -> None:
        self.sleep_until(self.now() + seconds)


def plain(level: int = 100, width: int = 32, height: int = 24) -> Image:
    return np.full((height, width, 3), level, np.uint8)


class FakeSource(Source[CameraDriver]):
    """A source whose pictures have these ``levels`` of brightness, the last one repeated. It records its calls."""

    def __init__(self, clock: Clock, levels: list[int] | None = None) -> None:
        super().__init__(EYE, CameraDriver(), clock)
        self.diary: list[str] = []
        self.levels = list(levels or [100])
        self.untaken: list[str] = []
        self.refused: list[str] = []
        self.failing: Exception | None = None
        self.picture: Callable[[int], Image] = plain
        self.on_shot: Callable[[], object] = lambda: None
        self.shots = 0

    def open(self) -> list[str]:
        self.diary.append("open")
        self._fail()
        return self.untaken

    def shoot(self) -> Shot:
        self.on_shot()
        self._fail()
        self.shots += 1
        level = self.levels.pop(0) if len(self.levels) > 1 else self.levels[0]
        return Shot(self.picture(level), self.clock.now())

    def read_exposure(self, shot: Shot) -> list[float]:
        return [float(shot.image[0, 0, 0])]

    def lock_exposure(self, shot: Shot) -> list[str]:
        self.diary.append(f"lock {shot.image[0, 0, 0]}")
        return self.refused

    def close(self) -> None:
        self.diary.append("close")

    def _fail(self) -> None:
        if self.failing:
            raise self.failing


def build_lost_error() -> DeviceError:
    return DeviceError("eye", "/dev/video0 is gone; plug it in again")


def open_camera(source: Source[Any], description: CameraDescription = EYE, **settings: Any) -> CapturingCamera:
    source.description, source.settings = description, CameraDriver(**settings)
    camera = CapturingCamera(source)
    camera.open()
    return camera


MANUAL, APERTURE_PRIORITY = 1, 3
FOUND_UNITS, FOUND_KELVIN = 156.0, 4600.0
"""The results of the automatic controls: 15.6 ms, in V4L2's unit of 100 us, and an office's colour temperature."""


FORMAT = {
    cv2.CAP_PROP_FOURCC,
    cv2.CAP_PROP_FRAME_WIDTH,
    cv2.CAP_PROP_FRAME_HEIGHT,
    cv2.CAP_PROP_FPS,
    cv2.CAP_PROP_BUFFERSIZE,
}


class FakeWebcam:
    """The simulated hardware of a webcam. Its controls stay after the end of a capture.

    sizes: the sizes of pictures. The nearest to the requested size is used.
    """

    def __init__(self, clock: LabClock, path: Path) -> None:
        self.clock, self.path = clock, path
        self.sizes = [(32, 24), (64, 48)]
        self.controls = {
            cv2.CAP_PROP_AUTO_EXPOSURE: float(MANUAL),
            cv2.CAP_PROP_EXPOSURE: 10.0,
            cv2.CAP_PROP_AUTO_WB: 0.0,
            cv2.CAP_PROP_WB_TEMPERATURE: 2800.0,
            cv2.CAP_PROP_GAIN: 0.0,
        }
        self.only_auto = APERTURE_PRIORITY
        self.lamp = 1.0
        self.stamp_offset_s = 0.0
        self.broken = 0
        self.is_busy = False
        self.captures: list[FakeCapture] = []
        path.touch()

    def meter(self) -> None:
        """Set exposure and white balance to the values of the automatic controls, if these are on."""
        is_automatic = self.controls.get(cv2.CAP_PROP_AUTO_EXPOSURE) == self.only_auto
        if is_automatic and cv2.CAP_PROP_EXPOSURE in self.controls:
            self.controls[cv2.CAP_PROP_EXPOSURE] += 0.5 * (FOUND_UNITS / self.lamp - self.exposure)
        if self.controls.get(cv2.CAP_PROP_AUTO_WB) == 1:
            self.controls[cv2.CAP_PROP_WB_TEMPERATURE] = FOUND_KELVIN

    @property
    def exposure(self) -> float:
        return self.controls.get(cv2.CAP_PROP_EXPOSURE, FOUND_UNITS)

    def capture(self, name: str, backend: int) -> FakeCapture:
        """Replace ``cv2.VideoCapture``."""
        assert backend == cv2.CAP_V4L2
        assert name == str(self.path)
        self.captures.append(FakeCapture(self))
        return self.captures[-1]


class FakeCapture:
    """A double of ``cv2.VideoCapture``. Width and height are set separately, before the first picture."""

    def __init__(self, camera: FakeWebcam) -> None:
        self._camera = camera
        self._stamp_s = 0.0
        self.asked: dict[int, float] = {}
        self.is_released = False

    def isOpened(self) -> bool:  # noqa: N802  OpenCV's name
        return self._camera.path.exists() and not self._camera.is_busy

    def set(self, prop: int, value: float) -> bool:
        if prop in FORMAT:
            assert prop != cv2.CAP_PROP_FOURCC or not self.asked, "a format after the size resets it"
            self.asked[prop] = value
            return True
        controls = self._camera.controls
        is_refused = (
            prop not in controls
            or (prop == cv2.CAP_PROP_AUTO_EXPOSURE and value not in {MANUAL, self._camera.only_auto})
            or (prop == cv2.CAP_PROP_EXPOSURE and controls[cv2.CAP_PROP_AUTO_EXPOSURE] != MANUAL)
        )
        if not is_refused:
            controls[prop] = value
        return not is_refused

    def get(self, prop: int) -> float:
        if prop == cv2.CAP_PROP_POS_MSEC:
            return self._stamp_s * 1000
        return self._camera.controls.get(prop, -1.0)

    def grab(self) -> bool:
        assert not self.is_released
        self._camera.meter()
        self._stamp_s = self._camera.clock.monotonic_s - 0.02 + self._camera.stamp_offset_s
        return self._camera.path.exists()

    def retrieve(self) -> tuple[bool, Image | None]:
        if self._camera.broken:
            self._camera.broken -= 1
            return False, None
        wanted = self.asked[cv2.CAP_PROP_FRAME_WIDTH]
        width, height = min(self._camera.sizes, key=lambda size: abs(size[0] - wanted))
        lit = np.array(RED_BGR) * self._camera.exposure * self._camera.lamp / FOUND_UNITS
        return True, np.full((height, width, 3), np.clip(np.round(lit), 0, 255), np.uint8)

    def release(self) -> None:
        self.is_released = True
