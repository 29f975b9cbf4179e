"""Measures the colour of an object before the camera, in the present light."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.autonomy.vision import Blob, ColourDetector
from robotcore.autonomy.vision.colour_detector import parse_hue
from robotcore.errors import CalibrationError
from robotcore.optics import Image, Intrinsics

Array = NDArray[np.float64]

SEARCH_TOLERANCE, SEARCH_SATURATION = 50.0, 0.12
"""The object is searched with these limits, in degrees and from 0 to 1. They are wider than those of apps."""

MIN_PIXELS = 60
"""The least number of pixels inside the object's edge in one picture."""

MIN_SHARE = 0.5
"""The object must be found in at least this share of the pictures."""

LEAST, MOST = 1.0, 99.0
"""The percentiles that are the limits of a range."""

MARGIN_FACTOR, MARGIN_DEGREES = 1.25, 4.0
"""The tolerance is the measured half range times the factor, plus the degrees: light changes with the place."""

MIN_TOLERANCE, MAX_TOLERANCE = 15.0, 60.0
"""The limits of the tolerance, in degrees. Beyond 60 degrees, the range would contain another primary colour."""

BRIGHT = 250
"""From this value on, a pixel is overexposed, and its hue is wrong."""

MAX_BRIGHT_SHARE = 0.1
"""The greatest share of overexposed pixels of the object."""

DETECTOR_SATURATION = 0.22
"""The least saturation of a blob for `ColourDetector`, by default."""


class Limits(NamedTuple):
    """The range that contains nearly all pixels of an object."""

    low: float
    high: float


@dataclass(frozen=True)
class HueFit:
    """The colour of an object in the present light, and how well apps detect it with these limits."""

    hue: float
    """The mean hue, in degrees."""
    tolerance: float
    """The tolerance to set, in degrees. It includes a margin."""
    hues: Limits
    """The measured range of hues, in degrees. The first may be negative, and the last above 360."""
    saturations: Limits
    """The measured range of saturations, from 0 to 1."""
    values: Limits
    """The measured range of values (HSV), from 0 to 1."""
    bright_share: float
    """The share of the object's pixels that are overexposed."""
    found_share: float
    """The share of the pictures in which a detector with these limits finds the object."""
    others: int
    """The number of other blobs with these limits in the picture that has most of them."""
    pictures: int
    """The number of pictures with the object."""

    @property
    def warnings(self) -> list[str]:
        """The problems of the object and the light, each as a sentence with the remedy."""
        found = []
        if self.saturations.low < DETECTOR_SATURATION:
            found.append(
                f"the palest parts have a saturation of {self.saturations.low:.2f}, and a detector needs "
                f"{DETECTOR_SATURATION:g}. Use an object of a stronger colour, or a softer light"
            )
        if self.bright_share > MAX_BRIGHT_SHARE:
            found.append(
                f"{self.bright_share:.0%} of the object is overexposed, which changes its hue. Reduce the light, or "
                "set exposure_s"
            )
        if self.found_share < 1.0:
            found.append(
                f"with these limits, a detector finds the object in {self.found_share:.0%} of the pictures. Give it "
                "more light, or move it nearer"
            )
        if self.others:
            found.append(
                f"{self.others} other things in the picture have this hue. Remove them, or use an object of another "
                "colour"
            )
        return found


def measure_hue(pictures: Sequence[Image], colour: str | float, intrinsics: Intrinsics) -> HueFit:
    """Return the limits of the largest object of about a colour in pictures.

    pictures: BGR pictures, each (height, width, 3).
    colour: the object's colour, by a name in `HUES` or in degrees.

    Raises UnknownNameError for an unknown name, and CalibrationError if the pictures show no such object.
    """
    nominal = parse_hue(colour)
    search = ColourDetector(nominal, tolerance=SEARCH_TOLERANCE, min_saturation=SEARCH_SATURATION, min_area=MIN_PIXELS)
    objects: list[tuple[Image, Blob]] = []
    pixels: list[Array] = []
    for picture in pictures:
        for blob in search.find(picture, intrinsics)[:1]:
            inside = _list_pixels(picture, blob, nominal)
            if len(inside) >= MIN_PIXELS:
                objects.append((picture, blob))
                pixels.append(inside)
    if len(objects) < max(1.0, MIN_SHARE * len(pictures)):
        raise CalibrationError(
            f"{len(objects)} of {len(pictures)} pictures show an object whose colour is like {colour}. Hold it before "
            "the camera, larger than a twentieth of the picture's width, or name another colour with --colour",
            kind="no-object",
            colour=colour,
        )
    hues, saturations, values = np.vstack(pixels).T
    angles = np.radians(hues)
    mean = math.degrees(math.atan2(np.sin(angles).mean(), np.cos(angles).mean())) % 360
    low, high = np.percentile((hues - mean + 180) % 360 - 180, (LEAST, MOST))
    needed = MARGIN_FACTOR * max(-low, high) + MARGIN_DEGREES
    tolerance = round(float(min(max(needed, MIN_TOLERANCE), MAX_TOLERANCE)), 0)
    hue = round(mean, 0) % 360
    is_found, others = _check(objects, ColourDetector(hue, tolerance=tolerance), intrinsics)
    return HueFit(
        hue,
        tolerance,
        Limits(mean + float(low), mean + float(high)),
        Limits(*map(float, np.percentile(saturations, (LEAST, MOST)))),
        Limits(*map(float, np.percentile(values / 255, (LEAST, MOST)))),
        float((values >= BRIGHT).mean()),
        is_found / len(objects),
        others,
        len(objects),
    )


def _list_pixels(picture: Image, blob: Blob, hue: float) -> Array:
    """Return hue in degrees, saturation and value of the pixels inside a blob, (n, 3), but of those at its edge.

    The value is from 0 to 255.
    """
    left, top, width, height = blob.box
    window = picture[top : top + height, left : left + width]
    hsv = cv2.cvtColor(window.astype(np.float32) / 255, cv2.COLOR_BGR2HSV)
    difference = np.abs((hsv[..., 0] - hue + 180) % 360 - 180)
    mask = ((difference < SEARCH_TOLERANCE) & (hsv[..., 1] > SEARCH_SATURATION)).astype(np.uint8)
    # A margin of zeros, so that the edge of the window is an edge of the object.
    inner = cv2.erode(cv2.copyMakeBorder(mask, 1, 1, 1, 1, cv2.BORDER_CONSTANT), np.ones((3, 3), np.uint8))[1:-1, 1:-1]
    chosen = hsv[inner.astype(bool)].astype(np.float64)
    return np.asarray(chosen * (1.0, 1.0, 255.0))


def _check(objects: Sequence[tuple[Image, Blob]], detector: ColourDetector, intrinsics: Intrinsics) -> tuple[int, int]:
    """Return in how many pictures a detector finds the object, and the greatest number of other blobs in one."""
    is_found = others = 0
    for picture, blob in objects:
        blobs = detector.find(picture, intrinsics)
        same = [each for each in blobs if _overlap(each.box, blob.box) > 0.25]
        is_found += bool(same)
        others = max(others, len(blobs) - len(same))
    return is_found, others


def _overlap(first: tuple[int, int, int, int], second: tuple[int, int, int, int]) -> float:
    """Return the area of the intersection of two boxes, divided by that of their union."""
    common = 1
    for axis in (0, 1):
        end = min(first[axis] + first[axis + 2], second[axis] + second[axis + 2])
        common *= max(end - max(first[axis], second[axis]), 0)
    return common / (first[2] * first[3] + second[2] * second[3] - common)
