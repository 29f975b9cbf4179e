"""Masks of a colour and their contours, for the compared finders."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.hal.devices import Image

Point = tuple[float, float]
"""A point in a picture: column and row, in pixels."""

Plane = NDArray[np.uint8]


def compute_hsv_mask(image: Image, hue: float, tolerance: float, min_saturation: int, min_value: int) -> Plane:
    """Return the mask of pixels within ``tolerance`` degrees of a hue that are neither grey nor dark."""
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    low, high = math.ceil((hue - tolerance) / 2), math.floor((hue + tolerance) / 2)
    mask = np.zeros(image.shape[:2], np.uint8)
    for turn in (-180, 0, 180):
        first, last = max(0, low + turn), min(179, high + turn)
        if first <= last:
            mask |= np.asarray(cv2.inRange(hsv, (first, min_saturation, min_value), (last, 255, 255)), np.uint8)
    return mask


def find_outlines(mask: Plane) -> Sequence[Any]:
    """Return the outer contours of a mask."""
    return cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)[0]


def find_largest(mask: Plane, min_area: float) -> Point | None:
    """Return the centroid of the largest contour of a mask; None if it encloses less than ``min_area`` pixels."""
    best = max(find_outlines(mask), key=cv2.contourArea, default=None)
    return None if best is None or cv2.contourArea(best) < min_area else compute_centroid(best)


def compute_centroid(contour: Any) -> Point:
    """Return the centroid of the area of a contour. If the area is empty, return the centroid of its points."""
    moments = cv2.moments(contour)
    if moments["m00"]:
        return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
    u, v = np.asarray(contour, np.float64).reshape(-1, 2).mean(axis=0)
    return float(u), float(v)


@lru_cache
def compute_pure_lab(hue: float) -> NDArray[np.float64]:
    """Return a* and b* of the saturated colour of a hue, of shape (2,)."""
    return _convert_pure(hue, cv2.COLOR_BGR2LAB)


@lru_cache
def compute_pure_chroma(hue: float) -> NDArray[np.float64]:
    """Return U and V of the saturated colour of a hue, of shape (2,). They are 0 for grey."""
    return _convert_pure(hue, cv2.COLOR_BGR2YUV)


def _convert_pure(hue: float, space: int) -> NDArray[np.float64]:
    bgr = np.array([[colorsys.hsv_to_rgb(hue / 360, 0.85, 0.8)[::-1]]]) * 255
    return np.asarray(cv2.cvtColor(bgr.astype(np.uint8), space)[0, 0, 1:], np.float64) - 128
