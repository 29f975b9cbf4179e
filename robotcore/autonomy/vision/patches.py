"""Connected patches of a mask, measured along their outlines."""

from __future__ import annotations

from typing import Any, NamedTuple

import cv2

from robotcore.autonomy.vision.wedge import Mask

Outline = Any
"""An outline as OpenCV has it: the pixels along the edge, (n, 1, 2), each a neighbour of the next."""

Box = tuple[int, int, int, int]


class Patch(NamedTuple):
    """A patch with its holes filled: pixels for ``centroid``, ``box`` (left, top, width, height) and ``area``."""

    centroid: tuple[float, float]
    box: Box
    area: int

    def lies_in(self, box: Box) -> bool:
        """Whether its centroid is within a box."""
        (u, v), (left, top, width, height) = self.centroid, box
        return left <= u < left + width and top <= v < top + height


def outlines(mask: Mask, offset: tuple[int, int] = (0, 0)) -> list[Outline]:
    """Return the outer outlines of the patches in a mask, moved by an offset in pixels."""
    found, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE, offset=offset)
    return list(found)


def pixels_in(outline: Outline) -> float:
    """Return how many pixels the patch within an outline has.

    An outline goes through the middles of the edge's pixels, so it encloses half of them. Pick's theorem counts the
    rest: pixels = enclosed area + edge / 2 + 1.
    """
    return cv2.contourArea(outline) + _not_enclosed(outline)


def measured(outline: Outline) -> Patch:
    """Return the patch within an outline; the pixels that it does not enclose lie where the edge does."""
    moments, edge = cv2.moments(outline), _not_enclosed(outline)
    edge_u, edge_v = cv2.mean(outline)[:2]
    area = moments["m00"] + edge
    centroid = (moments["m10"] + edge * edge_u) / area, (moments["m01"] + edge * edge_v) / area
    return Patch(centroid, box_of(outline), round(area))


def box_of(outline: Outline) -> Box:
    """Return the box around an outline: left, top, width, height."""
    left, top, width, height = cv2.boundingRect(outline)
    return left, top, width, height


def _not_enclosed(outline: Outline) -> float:
    return len(outline) / 2 + 1 if len(outline) > 1 else 1.0
