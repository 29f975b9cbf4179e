"""A detector for a colour, given by the name or the degrees of its hue."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.devices import Image, Intrinsics
from robotcore.errors import UnknownNameError, UsageError
from robotcore.vision.blob import Blob

HUES = {
    "red": 0.0,
    "orange": 28.0,
    "yellow": 53.0,
    "green": 128.0,
    "cyan": 184.0,
    "blue": 225.0,
    "purple": 273.0,
    "magenta": 316.0,
}
"""Hues by name, in degrees on the colour circle."""


def hue_of(hue: str | float) -> float:
    """Return a hue, given by name or in degrees, in [0, 360)."""
    try:
        degrees = float(hue)
    except ValueError:
        if hue not in HUES:
            raise UnknownNameError("hue", str(hue), list(HUES)) from None
        return HUES[str(hue)]
    if not math.isfinite(degrees):
        raise UsageError(f"the hue is {hue}; it must be a name or degrees from 0 to 360")
    return degrees % 360


class ColourDetector:
    """Finds patches of a hue in BGR pictures, largest first.

    A pixel belongs where its hue is within ``tolerance`` degrees and it is neither pale nor dark: OpenCV's HSV,
    saturation and value in 0 to 255.
    """

    def __init__(
        self,
        hue: str | float = "green",
        *,
        tolerance: float = 30.0,
        min_saturation: int = 90,
        min_value: int = 35,
        min_area: int = 12,
    ) -> None:
        self.hue = hue_of(hue)
        self._min_area = min_area
        self._shift = round(90 - self.hue / 2)
        self._lower = np.array((90 - tolerance / 2, min_saturation, min_value))
        self._upper = np.array((90 + tolerance / 2, 255, 255))
        self._centred = ((np.arange(256) + self._shift) % 180).astype(np.uint8)

    def mask(self, image: Image) -> NDArray[np.uint8]:
        """Return which pixels are of the hue: (height, width), 255 or 0."""
        hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
        hsv[:, :, 0] = cv2.LUT(hsv[:, :, 0], self._centred)
        return np.asarray(cv2.inRange(hsv, self._lower, self._upper), dtype=np.uint8)

    def find(self, image: Image, intrinsics: Intrinsics) -> list[Blob]:
        """Return the patches of at least ``min_area`` pixels, the largest first."""
        count, _, stats, centroids = cv2.connectedComponentsWithStats(self.mask(image))
        order = sorted(range(1, count), key=lambda i: -int(stats[i, cv2.CC_STAT_AREA]))
        return [
            _blob(stats[i].tolist(), centroids[i].tolist(), intrinsics)
            for i in order
            if stats[i, cv2.CC_STAT_AREA] >= self._min_area
        ]


def _blob(stats: list[int], centroid: list[float], intrinsics: Intrinsics) -> Blob:
    left, top, width, height, area = stats
    is_clipped = left == 0 or top == 0 or left + width == intrinsics.width or top + height == intrinsics.height
    u, v = centroid
    return Blob((u, v), (left, top, width, height), area, intrinsics.bearing(u), is_clipped)
