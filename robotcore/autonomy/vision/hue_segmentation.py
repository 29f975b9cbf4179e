"""Classifies pixels by hue with linear tests, and measures the regions that they form."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.optics import Image

Tests = NDArray[np.float32]
"""Three linear tests, one a row, (3, 4). A colour passes a test if the row times (b, g, r, 1) is at least 255."""

Mask = NDArray[np.uint8]
Row = tuple[float, float, float]
Rows = NDArray[np.float64]

STEEPNESS = 16.0
"""The slope of a test: how many output levels its value rises per grey level. From 32 on, OpenCV is slow."""

WEDGE_RATIO = 2.0
"""The tangent of each half angle of the wedge in `of_saturation`, divided by the tangent of the hue tolerance."""

WHITE = np.array((0, 0, 0, 255), np.float32)
PACKED_WHITE = 0xFFFF


class HueClassifier:
    """Makes linear tests for the colours of a hue.

    If brightness is ignored, a colour is a point in a plane. Grey is the plane's origin, and each hue is a direction.
    Chroma is the point's coordinate along the classifier's hue, in grey levels. Saturation is chroma divided by value,
    so light and shadow do not change it. For colours of exactly this hue, chroma and saturation equal those of HSV.
    The directions in the plane differ from the hues of HSV by at most 1.2 degrees.

    hue: the hue in degrees.
    below: the greatest difference of a smaller hue from ``hue``, in degrees.
    above: the greatest difference of a larger hue from ``hue``, in degrees.

    >>> green = HueClassifier(120.0, below=30.0, above=30.0)
    >>> round(green.chroma((20, 200, 20))), round(green.saturation((20, 200, 20)), 2)
    (180, 0.9)
    """

    def __init__(self, hue: float, below: float, above: float) -> None:
        self._chroma, self._value = _direction(hue), _value(hue)
        along, across, value = (np.array(row) for row in (self._chroma, _direction(hue + 90), self._value))
        narrow = np.radians((above, below))
        self._narrow = _make_tests(_sides(along, across, narrow), along) + WHITE
        self._per_chroma = _make_tests(np.zeros((2, 3)), np.zeros(3), (0.0, 0.0, 1.0))
        wide = np.arctan(WEDGE_RATIO * np.tan(narrow))
        sines = np.sin(wide)
        self._wide = _make_tests(_sides(along, across, wide), along) + WHITE
        self._per_saturation = _make_tests(np.outer(sines, value), value)
        self._per_distance = _make_tests(np.zeros((2, 3)), np.zeros(3), (*sines, 1.0))

    def chroma(self, bgr: tuple[float, ...]) -> float:
        """Return how strongly a colour shows this hue, in grey levels. It is negative for the opposite hues."""
        return _product(self._chroma, bgr)

    def saturation(self, bgr: tuple[float, ...]) -> float:
        """Return the saturation of a colour: its chroma divided by its value."""
        return self.chroma(bgr) / max(_product(self._value, bgr), 1.0)

    def of_chroma(self, least: float) -> Tests:
        """Return the tests for colours within the tolerance and with at least this chroma, in grey levels."""
        return self._narrow - least * self._per_chroma

    def of_saturation(self, least: float, distance: float) -> Tests:
        """Return the tests for colours in a wedge of the plane. Its tip lies on the line of the hue, away from grey.

        A less saturated colour must be nearer to the hue. A darker colour must be more saturated.

        least: the saturation at the tip.
        distance: the chroma at the tip in addition to that of ``least``, in grey levels.
        """
        tests: Tests = self._wide - distance * self._per_distance - least * self._per_saturation
        return tests


def find_hue(image: Image, tests: Tests) -> Mask:
    """Return for each pixel of a BGR picture 1 if it passes all three tests, else 0, (height, width).

    The product with the tests is white for exactly these pixels. It is packed into 16 bits a pixel, so that one
    comparison finds white.
    """
    packed = cv2.cvtColor(cv2.transform(image, tests), cv2.COLOR_BGR2BGR565)
    mask: Mask = (packed.view(np.uint16)[..., 0] == PACKED_WHITE).view(np.uint8)
    return mask


def _sides(along: Rows, across: Rows, half_angles: Rows) -> Rows:
    """Return the tests of the two sides of a wedge, one a row.

    half_angles: the angles between the middle and each side, in radians. The first side is the one towards ``across``.
    """
    sides: Rows = np.outer(np.sin(half_angles), along) + np.outer((-1, 1) * np.cos(half_angles), across)
    return sides


def _make_tests(sides: Rows, outwards: Rows, offsets: Row = (0.0, 0.0, 0.0)) -> Tests:
    return np.asarray(STEEPNESS * np.column_stack((np.vstack((sides, outwards)), offsets)), np.float32)


def _direction(degrees: float) -> Row:
    """Return the weights of blue, green and red that give a colour's coordinate along a direction of the plane."""
    blue, green, red = (math.cos(math.radians(primary - degrees)) for primary in (240, 120, 0))
    return blue, green, red


def _value(hue: float) -> Row:
    """Return the weights of blue, green and red that give the value (HSV) of a colour of this hue.

    The value is the mean of blue, green and red plus two thirds of the chroma along the nearest primary colour. The
    latter is the chroma along the hue times the cosine of the angle between the hue and the primary colour.
    """
    from_primary = math.radians(abs((hue + 60) % 120 - 60))
    blue, green, red = (1 / 3 + 2 / 3 * math.cos(from_primary) * part for part in _direction(hue))
    return blue, green, red


def _product(row: Row, bgr: tuple[float, ...]) -> float:
    return row[0] * bgr[0] + row[1] * bgr[1] + row[2] * bgr[2]


Contour = Any
"""A contour of OpenCV: the pixels along the edge in order, (n, 1, 2)."""

Box = tuple[int, int, int, int]


class Region(NamedTuple):
    """A connected region of a mask, with its holes filled."""

    centroid: tuple[float, float]
    """The column and the row of the centroid, in pixels."""
    box: Box
    """The left edge, the top edge, the width and the height of the bounding box, in pixels."""
    area: int
    """The number of pixels."""

    def lies_in(self, box: Box) -> bool:
        """Return whether the region's centroid is in a box."""
        (u, v), (left, top, width, height) = self.centroid, box
        return left <= u < left + width and top <= v < top + height


def find_contours(mask: Mask, offset: tuple[int, int] = (0, 0)) -> list[Contour]:
    """Return the outer contours of the regions in a mask.

    offset: (x, y) in pixels; it is added to each point of the contours.
    """
    found, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE, offset=offset)
    return list(found)


def pixels_in(contour: Contour) -> float:
    """Return the number of pixels in the region of a contour.

    A contour goes through the middles of the region's outermost pixels, so its area lacks about half of each. By Pick's
    theorem, the number of pixels is the contour's area + the number of outermost pixels / 2 + 1.
    """
    return cv2.contourArea(contour) + _not_enclosed(contour)


def measure_region(contour: Contour) -> Region:
    """Return the region of a contour.

    For the region's centroid, the area that the contour lacks counts as if it were at the centroid of the contour.
    """
    moments, edge = cv2.moments(contour), _not_enclosed(contour)
    edge_u, edge_v = cv2.mean(contour)[:2]
    area = moments["m00"] + edge
    centroid = (moments["m10"] + edge * edge_u) / area, (moments["m01"] + edge * edge_v) / area
    return Region(centroid, compute_box(contour), round(area))


def compute_box(contour: Contour) -> Box:
    """Return the box around a contour: left, top, width and height."""
    left, top, width, height = cv2.boundingRect(contour)
    return left, top, width, height


def _not_enclosed(contour: Contour) -> float:
    return len(contour) / 2 + 1 if len(contour) > 1 else 1.0
