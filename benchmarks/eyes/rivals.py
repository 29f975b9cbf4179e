"""Published ways to find a ball by its colour, each in a few lines from its description; one answer a frame.

A rival is called with a BGR picture and a hue in degrees, and returns the ball's place in pixels, or None. Its defaults
are what was published.
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.devices import Image

Place = tuple[float, float]
Finder = Callable[[Image, float], Place | None]
Plane = NDArray[np.uint8]


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

    def __call__(self, image: Image, hue: float) -> Place | None:
        if self.is_smoothed:
            image = np.asarray(cv2.GaussianBlur(image, (5, 5), 0), np.uint8)
        mask = hsv_mask(image, hue, self.tolerance, self.min_saturation, self.min_value)
        if self.is_smoothed:
            kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
            mask = np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel), np.uint8)
        return largest(mask, self.min_area)


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

    def __call__(self, image: Image, hue: float) -> Place | None:
        scale = self.width / image.shape[1]
        image = np.asarray(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
        image = np.asarray(cv2.GaussianBlur(image, (self.blur, self.blur), 0), np.uint8)
        mask = hsv_mask(image, hue, self.tolerance, self.min_saturation, self.min_value)
        kernel = np.ones((3, 3), np.uint8)
        mask = np.asarray(cv2.erode(mask, kernel, iterations=self.rounds), np.uint8)
        mask = np.asarray(cv2.dilate(mask, kernel, iterations=self.rounds), np.uint8)
        contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        best = max(contours, key=cv2.contourArea, default=None)
        if best is None or cv2.minEnclosingCircle(best)[1] < self.min_radius:
            return None
        u, v = middle_of(best)
        return (u + 0.5) / scale - 0.5, (v + 0.5) / scale - 0.5


@dataclass(frozen=True)
class FindBlobs:
    """OpenMV's ``image.find_blobs``: a box in CIE L*a*b*, connected pixels, the largest blob; at least 10 pixels.

    Its examples name a box for red, green and blue; here every hue has one of that kind, from a part ``weakest`` of the
    pure colour's a* and b*, give or take ``slack``, outwards.
    """

    weakest: float = 0.15
    slack: float = 25.0
    min_lightness: float = 30.0
    min_pixels: int = 10

    def __call__(self, image: Image, hue: float) -> Place | None:
        lab = cv2.cvtColor(image, cv2.COLOR_BGR2LAB)
        return largest(np.asarray(cv2.inRange(lab, *self._box(hue)), np.uint8), self.min_pixels)

    def _box(self, hue: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        pure = pure_lab(hue)
        low = np.minimum(self.weakest * pure, pure) - self.slack + 128
        high = np.maximum(self.weakest * pure, pure) + self.slack + 128
        return np.array((self.min_lightness * 2.55, *low)), np.array((255.0, *high))


@dataclass(frozen=True)
class ChromaTable:
    """As CMVision (Bruce, Balch and Veloso, IROS 2000): a box in YUV's two colour channels, connected regions.

    ``nearest`` and ``beside`` say how far the box goes, in parts of the pure colour's distance from grey.
    """

    nearest: float = 0.25
    beside: float = 0.35
    min_luma: int = 30
    min_area: int = 10

    def __call__(self, image: Image, hue: float) -> Place | None:
        pure = pure_chroma(hue)
        reach = float(np.linalg.norm(pure))
        low = np.minimum(self.nearest * pure, pure) - self.beside * reach + 128
        high = np.maximum(self.nearest * pure, pure) + self.beside * reach + 128
        yuv = cv2.cvtColor(image, cv2.COLOR_BGR2YUV)
        mask = cv2.inRange(yuv, np.array((float(self.min_luma), *low)), np.array((255.0, *high)))
        return largest(np.asarray(mask, np.uint8), self.min_area)


def hsv_mask(image: Image, hue: float, tolerance: float, min_saturation: int, min_value: int) -> Plane:
    """Return where a picture is within ``tolerance`` degrees of a hue; two ranges where it crosses red."""
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    low, high = (hue - tolerance) / 2, (hue + tolerance) / 2
    mask = np.zeros(image.shape[:2], np.uint8)
    for turn in (-180, 0, 180):
        if low + turn < 180 and high + turn >= 0:
            mask |= np.asarray(
                cv2.inRange(
                    hsv,
                    np.array((max(0, math.ceil(low + turn)), min_saturation, min_value)),
                    np.array((min(179, math.floor(high + turn)), 255, 255)),
                ),
                np.uint8,
            )
    return mask


def largest(mask: Plane, min_area: float) -> Place | None:
    """Return the middle of the largest contour, if it encloses ``min_area`` pixels."""
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    best = max(contours, key=cv2.contourArea, default=None)
    return None if best is None or cv2.contourArea(best) < min_area else middle_of(best)


def middle_of(contour: NDArray[np.generic]) -> Place:
    """Return the centroid of what a contour encloses; of its points, where that is nothing."""
    moments = cv2.moments(contour)
    if moments["m00"]:
        return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
    u, v = np.asarray(contour, np.float64).reshape(-1, 2).mean(axis=0)
    return float(u), float(v)


@lru_cache
def pure_lab(hue: float) -> NDArray[np.float64]:
    """Return a* and b* of a saturated colour of a hue, (2,)."""
    return _pure(hue, cv2.COLOR_BGR2LAB)


@lru_cache
def pure_chroma(hue: float) -> NDArray[np.float64]:
    """Return U and V of a saturated colour of a hue, (2,), 0 for grey."""
    return _pure(hue, cv2.COLOR_BGR2YUV)


def _pure(hue: float, space: int) -> NDArray[np.float64]:
    bgr = np.array([[colorsys.hsv_to_rgb(hue / 360, 0.85, 0.8)[::-1]]]) * 255
    return np.asarray(cv2.cvtColor(bgr.astype(np.uint8), space)[0, 0, 1:], np.float64) - 128
