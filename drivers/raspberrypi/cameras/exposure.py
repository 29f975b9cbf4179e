"""Exposure and white balance: left to the camera until they have settled, then held."""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Sequence

from drivers.raspberrypi.cameras.settings import CameraSettings
from drivers.raspberrypi.cameras.source import ExposureState, Shot, Source
from robotcore.hal.clock import Clock

STEADY_SHOTS = 10
"""Settled is what has not moved for as many pictures: a third of a second, longer than a camera takes to react."""

STEADY_RATIO = 1.03
"""Between the greatest and the smallest of them; the noise of a picture's mean is far below."""

DARK = 4.0
"""So many levels of 255 are added before a ratio is taken: black is noise, and divides by nothing."""

FRAMES_IN_FLIGHT = 8
"""As many pictures may be under way, taken by what was set before: libcamera's queue and the sensor's own delay.
Source: https://github.com/raspberrypi/libcamera, src/ipa/rpi: two frames of delay; picamera2: six buffers."""

BRIGHTNESS_TOLERANCE = 1.25
"""A picture whose brightness changes by more when it is held was not held where it was."""

_log = logging.getLogger(__name__)


class ExposureLock:
    """Brings a source to a picture that stays as it is. What it does not manage is a warning, once."""

    def __init__(self, source: Source, settings: CameraSettings, clock: Clock) -> None:
        self._source, self._settings, self._clock = source, settings, clock
        self._warned: set[str] = set()

    def begin(self) -> Shot:
        """Open the source; return its first picture, settled and held where that is asked for."""
        if untaken := self._source.open():
            self._warn(f"does not take {', '.join(untaken)}; take it out of the robot's file")
        shot = self._source.shoot()
        if not self._settings.lock:
            return shot
        return self._hold(self._settle(shot))

    def _settle(self, shot: Shot) -> Shot:
        until = self._clock.now() + self._settings.settle_s
        states: deque[ExposureState] = deque(maxlen=STEADY_SHOTS)
        for _ in range(math.ceil(self._settings.settle_s * self._settings.fps)):
            states.append(self._source.read_exposure(shot))
            if _is_steady(states) or self._clock.now() >= until:
                break
            shot = self._source.shoot()
        return shot

    def _hold(self, before: Shot) -> Shot:
        refused = self._source.hold(before)
        for _ in range(FRAMES_IN_FLIGHT):
            after = self._source.shoot()
        if refused:
            self._warn(f"does not let its {' and '.join(refused)} be held; colours may drift as the robot drives")
        change = (after.image.mean() + DARK) / (before.image.mean() + DARK)
        if not 1 / BRIGHTNESS_TOLERANCE < change < BRIGHTNESS_TOLERANCE:
            self._warn(f"became {change:.1f} times as bright when it was held; set exposure_s by hand, or lock = false")
        return after

    def _warn(self, words: str) -> None:
        if words not in self._warned:
            self._warned.add(words)
            _log.warning("%s: %s", self._source.name, words)


def _is_steady(states: Sequence[ExposureState]) -> bool:
    """Return whether nothing has moved for long enough, and the camera says nothing else."""
    if len(states) < STEADY_SHOTS or states[-1].is_settled is False:
        return False
    courses = zip(*(state.values for state in states), strict=True)
    return all(max(course) <= STEADY_RATIO * min(course) for course in courses)
