"""Published ways to find a ball by its colour, each in a few lines from its description; one answer a frame.

A rival is called with a BGR picture and a hue in degrees, and returns the ball's place in pixels, or None.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.eyes.masks import (
    Point,
    compute_centroid,
    compute_hsv_mask,
    compute_pure_chroma,
    compute_pure_lab,
    find_largest,
    find_outlines,
)
from robotcore.hal.devices import Image


@dataclass(frozen=True)
class Classical:
    """HSV, ``inRange``, ``findContours``, the largest contour: what most colour followers do.

    ``is_smoothed`` puts a Gaussian blur of 5 × 5 before and an opening of 3 × 3 after the thresholds. The thresholds
    are those of OpenCV's tutorial "Changing Colorspaces" (a hue ± 10 of 180, saturation and value from 50).
    """

    tolerance: float = 20.0
    min_saturation: int = 50
    min_value: int = 50
    min_area: int = 0
    is_smoothed: bool = False

    def __call__(self, image: Image, hue: float) -> Point | None:
        if self.is_smoothed:
            image = np.asarray(cv2.GaussianBlur(image, (5, 5), 0), np.uint8)
        mask = compute_hsv_mask(image, hue, self.tolerance, self.min_saturation, self.min_value)
        if self.is_smoothed:
            kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
            mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel), np.uint8)
        return find_largest(mask, self.min_area)


@dataclass(frozen=True)
class BallTracking:
    """The tutorial "Ball Tracking with OpenCV" (Rosebrock, pyimagesearch.com, 2015), which robots have copied since.

    600 pixels wide, a Gaussian blur of 11 × 11, HSV, two erosions, two dilations, the largest contour, its enclosing
    circle, of which at least 10 pixels of radius. Its green is a hue of ± 35 degrees; so is every hue here.
    """

    width: int = 600
    tolerance: float = 35.0
    min_saturation: int = 86
    min_value: int = 6
    min_radius: float = 10.0
    rounds: int = 2
    blur: int = 11

    def __call__(self, image: Image, hue: float) -> Point | None:
        scale = self.width / image.shape[1]
        image = np.asarray(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
        image = np.asarray(cv2.GaussianBlur(image, (self.blur, self.blur), 0), np.uint8)
        mask = compute_hsv_mask(image, hue, self.tolerance, self.min_saturation, self.min_value)
        kernel = np.ones((3, 3), np.uint8)
        mask = np.asarray(cv2.erode(mask, kernel, iterations=self.rounds), np.uint8)
        mask = np.asarray(cv2.dilate(mask, kernel, iterations=self.rounds), np.uint8)
        best = max(find_outlines(mask), key=cv2.contourArea, default=None)
        if best is None or cv2.minEnclosingCircle(best)[1] < self.min_radius:
            return None
        u, v = compute_centroid(best)
        return (u + 0.5) / scale - 0.5, (v + 0.5) / scale - 0.5


@dataclass(frozen=True)
class FindBlobs:
    """OpenMV's ``image.find_blobs``: a box in CIE L*a*b*, connected pixels, the largest blob.

    The box is the user's; here it reaches from a part ``weakest`` of a pure colour's a* and b* to all of it, give or
    take ``slack``.
    """

    weakest: float
    slack: float
    min_lightness: float
    min_pixels: int

    def __call__(self, image: Image, hue: float) -> Point | None:
        lab = cv2.cvtColor(image, cv2.COLOR_BGR2LAB)
        return find_largest(np.asarray(cv2.inRange(lab, *self._box(hue)), np.uint8), self.min_pixels)

    def _box(self, hue: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        pure = compute_pure_lab(hue)
        low = np.minimum(self.weakest * pure, pure) - self.slack + 128
        high = np.maximum(self.weakest * pure, pure) + self.slack + 128
        return np.array((self.min_lightness * 2.55, *low)), np.array((255.0, *high))


@dataclass(frozen=True)
class ChromaTable:
    """As CMVision (Bruce, Balch and Veloso, IROS 2000): a box in YUV, connected regions, the largest.

    The box is the user's; here it reaches from a part ``nearest`` of a pure colour's U and V to all of it, and by
    ``beside`` farther to all sides, in parts of that colour's distance from grey.
    """

    nearest: float
    beside: float
    min_luma: int
    min_area: int

    def __call__(self, image: Image, hue: float) -> Point | None:
        pure = compute_pure_chroma(hue)
        reach = float(np.linalg.norm(pure))
        low = np.minimum(self.nearest * pure, pure) - self.beside * reach + 128
        high = np.maximum(self.nearest * pure, pure) + self.beside * reach + 128
        yuv = cv2.cvtColor(image, cv2.COLOR_BGR2YUV)
        mask = cv2.inRange(yuv, np.array((float(self.min_luma), *low)), np.array((255.0, *high)))
        return find_largest(np.asarray(mask, np.uint8), self.min_area)
