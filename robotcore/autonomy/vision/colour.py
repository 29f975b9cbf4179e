"""A patch of one colour in a picture."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from robotcore.autonomy.vision.regions import (
    Box,
    HueClassifier,
    Region,
    box_of,
    find_hue,
    measure_region,
    outlines,
    pixels_in,
)
from robotcore.errors import UnknownNameError, UsageError
from robotcore.hal.devices import Image
from robotcore.optics import Intrinsics


@dataclass(frozen=True, slots=True)
class Blob:
    """A connected patch: pixels for ``centroid``, ``box`` (left, top, width, height) and ``area``.

    ``bearing`` is the direction of the centroid in radians, positive to the left. ``is_clipped`` says that the patch
    touches the picture's edge: what it belongs to is larger than what is seen.
    """

    centroid: tuple[float, float]
    box: tuple[int, int, int, int]
    area: int
    bearing: float
    is_clipped: bool

    @property
    def radius(self) -> float:
        """Half of the box's longer side, in pixels: a ball's, where it is neither clipped nor covered."""
        return max(self.box[2], self.box[3]) / 2


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


CAST, ALWAYS_ENOUGH = 0.6, 0.38
"""A picture that as a whole has a saturation s in the hue asks for CAST · s more; the other is always enough."""

SHARE = 0.5
"""A patch ends where its chroma has fallen to this share of its mean: half way down a blurred edge."""

MARGIN_PX = 3

FEW, MOST = 4, 8
"""A ball is one patch; where more than a few show up there is noise or texture. At most so many are measured."""


class ColourDetector:
    """Finds patches of a hue in BGR pictures, largest first.

    Something is seen where, at half size, the saturation in the hue is at least ``min_saturation`` (0 to 1; more in a
    picture that is tinged with the hue) and the chroma ``min_chroma`` grey levels above that. It is measured at full
    size, where the hue is within ``tolerance`` degrees; holes are filled. What lies in a larger patch's box is left
    out, and so are the smallest of more than eight.

    >>> from robotcore.optics import Intrinsics
    >>> picture = np.full((240, 320, 3), 128, np.uint8)
    >>> picture[100:120, 50:80] = (60, 170, 40)
    >>> [(blob.box, blob.area) for blob in ColourDetector("green").find(picture, Intrinsics(320, 240, 1.0))]
    [((50, 100, 30, 20), 600)]
    """

    def __init__(
        self,
        hue: str | float = "green",
        *,
        tolerance: float = 30.0,
        min_saturation: float = 0.22,
        min_chroma: float = 8.0,
        min_area: int = 12,
    ) -> None:
        if not 0 < tolerance < 90:
            raise UsageError(f"the tolerance is {tolerance:g} degrees; take more than 0 and less than 90")
        if not min_area >= 1:
            raise UsageError(f"the smallest area is {min_area} pixels; take 1 or more")
        self.hue = hue_of(hue)
        self._hue_classifier = HueClassifier(self.hue, tolerance)
        self._min_saturation = min_saturation
        self._min_chroma = min_chroma
        self._min_area = min_area

    def find(self, image: Image, intrinsics: Intrinsics) -> list[Blob]:
        """Return the patches of at least ``min_area`` pixels, the largest first; UsageError where a picture is grey."""
        if image.ndim != 3:
            raise UsageError(f"a grey picture, {image.shape}, has no hues; hand over a BGR one, (height, width, 3)")
        apart: list[Region] = []
        for patch in sorted(self._patches(image), key=_area, reverse=True):
            if not any(patch.lies_in(larger.box) for larger in apart):
                apart.append(patch)
        return [_blob(patch, intrinsics) for patch in apart]

    def _patches(self, image: Image) -> Iterator[Region]:
        """Yield what there is at full size wherever something is seen at half size; a patch may come twice."""
        height, width = image.shape[:2]
        size = (width + 1) // 2, (height + 1) // 2
        half = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
        for box, chroma in self._seen(half):
            yield from self._patches_near(image, box, SHARE * chroma)

    def _seen(self, image: Image) -> Iterator[tuple[Box, float]]:
        """Yield the box and the mean chroma of each candidate; where many show up, look again with softer eyes."""
        tests = self._hue_classifier.of_saturation(self._saturation_asked(image), self._min_chroma)
        mask = find_hue(image, tests)
        candidates = outlines(mask)
        if len(candidates) > FEW:
            image = np.asarray(cv2.blur(image, (3, 3)), np.uint8)
            mask = find_hue(image, tests)
            candidates = sorted(outlines(mask), key=pixels_in)[-MOST:]
        for candidate in candidates:
            left, top, width, height = box = box_of(candidate)
            inside = slice(top, top + height), slice(left, left + width)
            yield box, self._hue_classifier.chroma(cv2.mean(image[inside], mask[inside]))

    def _patches_near(self, image: Image, box: Box, chroma: float) -> Iterator[Region]:
        """Yield the patches of at least this chroma in what a box at half size covers, and a little around it."""
        left, top, width, height = box
        right, bottom = 2 * (left + width) + MARGIN_PX, 2 * (top + height) + MARGIN_PX
        left, top = max(0, 2 * left - MARGIN_PX), max(0, 2 * top - MARGIN_PX)
        window = image[top:bottom, left:right].copy()  # OpenCV takes rows that lie together as one
        for outline in outlines(find_hue(window, self._hue_classifier.of_chroma(chroma)), (left, top)):
            if pixels_in(outline) >= self._min_area:
                yield measure_region(outline)

    def _saturation_asked(self, image: Image) -> float:
        """Return the saturation to ask for: more, where the light or a lawn lends everything something of the hue."""
        cast = CAST * max(0.0, self._hue_classifier.saturation(cv2.mean(image)))
        return max(self._min_saturation, min(self._min_saturation + cast, ALWAYS_ENOUGH))


def _area(patch: Region) -> int:
    return patch.area


def _blob(patch: Region, intrinsics: Intrinsics) -> Blob:
    left, top, width, height = patch.box
    is_clipped = left == 0 or top == 0 or left + width == intrinsics.width or top + height == intrinsics.height
    return Blob(patch.centroid, patch.box, patch.area, intrinsics.bearing(patch.centroid[0]), is_clipped)
