"""Pixels of a hue by linear tests, and the regions that they form."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.hal.devices import Image

Tests = NDArray[np.float32]
"""Three tests, (3, 4): a colour (b, g, r, 1) passes one where the product is white, 255, or more."""

Mask = NDArray[np.uint8]
Row = tuple[float, float, float]
Rows = NDArray[np.float64]

STEEPNESS = 16.0
"""By how much a colour falls short of white for each grey level that it fails a test by; OpenCV is slow from 32."""

OPENING = 2.0
"""How much wider, as a tangent, the wedge is that starts away from grey."""

WHITE = np.array((0, 0, 0, 255), np.float32)
PACKED_WHITE = 0xFFFF


class HueClassifier:
    """The colours of a hue in degrees, give or take ``tolerance`` degrees.

    Brightness apart, a colour is a point of a plane in which grey is the middle and hue a direction. Its chroma is how
    far it lies along the asked-for hue, in grey levels; its saturation is chroma over value, which light and shadow
    leave as it is. For a colour of the very hue they are those of HSV; the plane's directions and HSV's hues differ by
    1.2 degrees at most.

    >>> green = HueClassifier(120.0, tolerance=30.0)
    >>> round(green.chroma((20, 200, 20))), round(green.saturation((20, 200, 20)), 2)
    (180, 0.9)
    """

    def __init__(self, hue: float, tolerance: float) -> None:
        self._chroma, self._value = _direction(hue), _value(hue)
        along, across, value = (np.array(row) for row in (self._chroma, _direction(hue + 90), self._value))
        narrow = math.radians(tolerance)
        self._narrow = _steep(_sides(along, across, narrow), along) + WHITE
        self._per_chroma = _steep(np.zeros((2, 3)), np.zeros(3), (0.0, 0.0, 1.0))
        wide = math.atan(OPENING * math.tan(narrow))
        sine = math.sin(wide)
        self._wide = _steep(_sides(along, across, wide), along) + WHITE
        self._per_saturation = _steep(np.array((sine * value, sine * value)), value)
        self._per_distance = _steep(np.zeros((2, 3)), np.zeros(3), (sine, sine, 1.0))

    def chroma(self, bgr: tuple[float, ...]) -> float:
        """Return how far a colour lies along the hue, in grey levels; below 0 on the other side of grey."""
        return _product(self._chroma, bgr)

    def saturation(self, bgr: tuple[float, ...]) -> float:
        """Return a colour's chroma as a part of its value."""
        return self.chroma(bgr) / max(_product(self._value, bgr), 1.0)

    def of_chroma(self, least: float) -> Tests:
        """Return the tests for the colours within the tolerance that have at least this chroma."""
        return self._narrow - least * self._per_chroma

    def of_saturation(self, least: float, distance: float) -> Tests:
        """Return the tests for a wider wedge that starts ``distance`` grey levels beyond a saturation of ``least``.

        So the duller a colour, the nearer to the hue it must be; the darker, the more saturated.
        """
        tests: Tests = self._wide - distance * self._per_distance - least * self._per_saturation
        return tests


def find_hue(image: Image, tests: Tests) -> Mask:
    """Return which pixels of a BGR picture pass all three tests: (height, width), 1 or 0.

    One matrix product makes a picture that is white where the tests are passed; packed into 16 bits, white is all ones.
    """
    packed = cv2.cvtColor(cv2.transform(image, tests), cv2.COLOR_BGR2BGR565)
    mask: Mask = (packed.view(np.uint16)[..., 0] == PACKED_WHITE).view(np.uint8)
    return mask


def _sides(along: Rows, across: Rows, half_angle: float) -> Rows:
    """Return the tests for being within an angle of the hue, on one side and on the other."""
    sine, cosine = math.sin(half_angle), math.cos(half_angle)
    return np.array((sine * along - cosine * across, sine * along + cosine * across))


def _steep(sides: Rows, outwards: Rows, offsets: Row = (0.0, 0.0, 0.0)) -> Tests:
    return np.asarray(STEEPNESS * np.column_stack((np.vstack((sides, outwards)), offsets)), np.float32)


def _direction(degrees: float) -> Row:
    """Return what blue, green and red count along a direction of the plane; they themselves lie at 240, 120 and 0."""
    blue, green, red = (math.cos(math.radians(primary - degrees)) for primary in (240, 120, 0))
    return blue, green, red


def _value(hue: float) -> Row:
    """Return what blue, green and red count in the value, the largest of them, of a colour of the hue.

    It is their mean and two thirds of the chroma along the nearest primary, which is the chroma along the hue times the
    cosine between the two.
    """
    from_primary = math.radians(abs((hue + 60) % 120 - 60))
    blue, green, red = (1 / 3 + 2 / 3 * math.cos(from_primary) * part for part in _direction(hue))
    return blue, green, red


def _product(row: Row, bgr: tuple[float, ...]) -> float:
    return row[0] * bgr[0] + row[1] * bgr[1] + row[2] * bgr[2]


Contour = Any
"""An outline as OpenCV has it: the pixels along the edge, (n, 1, 2), each a neighbour of the next."""

Box = tuple[int, int, int, int]


class Region(NamedTuple):
    """A patch with its holes filled: pixels for ``centroid``, ``box`` (left, top, width, height) and ``area``."""

    centroid: tuple[float, float]
    box: Box
    area: int

    def lies_in(self, box: Box) -> bool:
        """Whether its centroid is within a box."""
        (u, v), (left, top, width, height) = self.centroid, box
        return left <= u < left + width and top <= v < top + height


def outlines(mask: Mask, offset: tuple[int, int] = (0, 0)) -> list[Contour]:
    """Return the outer outlines of the patches in a mask, moved by an offset in pixels."""
    found, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE, offset=offset)
    return list(found)


def pixels_in(outline: Contour) -> float:
    """Return how many pixels the patch within an outline has.

    An outline goes through the middles of the edge's pixels, so it encloses half of them. Pick's theorem counts the
    rest: pixels = enclosed area + edge / 2 + 1.
    """
    return cv2.contourArea(outline) + _not_enclosed(outline)


def measure_region(outline: Contour) -> Region:
    """Return the patch within an outline; the pixels that it does not enclose lie where the edge does."""
    moments, edge = cv2.moments(outline), _not_enclosed(outline)
    edge_u, edge_v = cv2.mean(outline)[:2]
    area = moments["m00"] + edge
    centroid = (moments["m10"] + edge * edge_u) / area, (moments["m01"] + edge * edge_v) / area
    return Region(centroid, box_of(outline), round(area))


def box_of(outline: Contour) -> Box:
    """Return the box around an outline: left, top, width, height."""
    left, top, width, height = cv2.boundingRect(outline)
    return left, top, width, height


def _not_enclosed(outline: Contour) -> float:
    return len(outline) / 2 + 1 if len(outline) > 1 else 1.0
