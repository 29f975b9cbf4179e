"""The rivals of the detector: published methods to find a ball by its colour, implemented from their descriptions.

Each is a `Finder`, which returns one position for each frame, or None.
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
    """The usual pipeline: HSV, ``inRange``, ``findContours``, and the largest contour.

    ``is_smoothed`` adds a Gaussian blur of 5 × 5 before the thresholds, and an opening of 3 × 3 after them. The default
    thresholds are from OpenCV's tutorial "Changing Colorspaces": a hue ± 10 of 180, saturation and value from 50.
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
    """The pipeline of the tutorial "Ball Tracking with OpenCV" (Rosebrock, pyimagesearch.com, 2015).

    It resizes the picture to 600 pixels, blurs it (Gaussian, 11 × 11), and thresholds it in HSV. After two erosions and
    two dilations, it takes the largest contour, whose enclosing circle must have a radius of at least 10 pixels. The
    tutorial's green spans ± 35 degrees of hue. Here every hue does.
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
    """OpenMV's ``image.find_blobs``: a box of thresholds in CIE L*a*b*, connected pixels, and the largest blob.

    On OpenMV the user chooses the box. Here it spans a* and b* from ``weakest`` times those of the pure colour to those
    of the pure colour, widened by ``slack``.
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
    """The method of CMVision (Bruce, Balch, Veloso, IROS 2000): a box in YUV, connected regions, and the largest one.

    In CMVision the user chooses the box. Here it spans U and V from ``nearest`` times those of the pure colour to those
    of the pure colour. It is widened by ``beside`` times the pure colour's distance from grey.
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
