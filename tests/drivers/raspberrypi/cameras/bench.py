"""A clock whose kernel stamps can be told, and a camera without hardware for what all cameras share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from drivers.raspberrypi.cameras.capturing import CapturingCamera
from drivers.raspberrypi.cameras.settings import CameraSettings
from drivers.raspberrypi.cameras.source import Light, Shot, Source
from robotcore.description import CameraDescription, load_robot
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.devices import Image

BOOTED_S = 5000.0
"""What CLOCK_MONOTONIC says when the clock begins."""

FOUND = load_robot("rover").first_of(CameraDescription)
assert FOUND
EYE = FOUND.model_copy(update={"width_px": 32, "height_px": 24})

RED_RGB = (200, 40, 30)
RED_BGR = RED_RGB[::-1]


class LabClock(SteppedClock):
    """Stepped, and yet with moments of the kernel, which runs with it."""

    def __init__(self) -> None:
        super().__init__(20, lambda _steps: None)

    @property
    def monotonic_s(self) -> float:
        return BOOTED_S + self.now()

    def time_of(self, monotonic_s: float) -> float:
        return min(monotonic_s - BOOTED_S, self.now())

    def let_pass(self, seconds: float) -> None:
        self.sleep_until(self.now() + seconds)


def plain(level: int = 100, width: int = 32, height: int = 24) -> Image:
    return np.full((height, width, 3), level, np.uint8)


class FakeSource(Source):
    """Takes pictures of ``levels``, the last one for ever, and keeps a diary of what is asked of it."""

    def __init__(self, clock: Clock, levels: list[int] | None = None) -> None:
        super().__init__("eye")
        self.diary: list[str] = []
        self.levels = list(levels or [100])
        self.untaken: list[str] = []
        self.refused: list[str] = []
        self.failing: Exception | None = None
        self.is_found: bool | None = None
        self.picture: Callable[[int], Image] = plain
        self.on_shot: Callable[[], object] = lambda: None
        self.shots = 0
        self._clock = clock

    def open(self) -> list[str]:
        self.diary.append("open")
        self._fail()
        return self.untaken

    def shoot(self) -> Shot:
        self.on_shot()
        self._fail()
        self.shots += 1
        level = self.levels.pop(0) if len(self.levels) > 1 else self.levels[0]
        return Shot(self.picture(level), self._clock.now())

    def light(self, shot: Shot) -> Light:
        return Light((float(shot.image[0, 0, 0]),), self.is_found)

    def hold(self, shot: Shot) -> list[str]:
        self.diary.append(f"hold {shot.image[0, 0, 0]}")
        return self.refused

    def close(self) -> None:
        self.diary.append("close")

    def _fail(self) -> None:
        if self.failing:
            raise self.failing


def gone() -> DeviceError:
    return DeviceError("eye", "/dev/video0 is gone; plug it in again")


def opened(source: Source, clock: Clock, told: CameraDescription = EYE, **settings: Any) -> CapturingCamera:
    camera = CapturingCamera(told, CameraSettings(**settings), source, clock)
    camera.open()
    return camera
