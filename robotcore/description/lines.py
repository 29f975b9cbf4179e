"""The lines on the floor of a world, such as adhesive tape."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from robotcore.description.types import COLOURS, Colour, Coordinate, Metres, StrictModel
from robotcore.errors import Mistake

Array = NDArray[np.float64]

Point = Annotated[tuple[Coordinate, Coordinate], Field(description="[x, y]")]
"""A point on the floor in the world's frame, in metres."""

Segment = tuple[tuple[float, float], tuple[float, float]]
"""The start and the end of a straight part of a line, in metres."""

MAX_LINE_POINTS = 1000
"""The greatest number of points of all lines in a world, so that pictures and samples take little time."""

MIN_LENGTH_M = 1e-6
"""The least distance between neighbouring points of a line, in metres."""

_ARC_STEPS = 12
"""The number of edges of the half circle at each end of a segment's outline."""


class Line(StrictModel):
    """A line on the floor: all points that are at most half its width from a polyline.

    >>> line = Line(width_m=0.018, points_m=[(0, 0), (1, 0), (1, 1)], colour="blue")
    >>> line.segments, line.colour
    ((((0.0, 0.0), (1.0, 0.0)), ((1.0, 0.0), (1.0, 1.0))), (40, 80, 200))
    """

    width_m: Metres
    points_m: Annotated[
        tuple[Point, ...],
        Field(min_length=2, description="a list of at least two points: [[x, y], [x, y]]"),
    ]
    """The corners of the polyline in the world's frame, in metres."""
    colour: Colour = COLOURS["black"]
    closed: bool = False
    """Whether the line continues from the last point to the first."""

    @model_validator(mode="after")
    def _require_distinct_points(self) -> Line:
        for number, (start, end) in enumerate(self.segments, start=1):
            if math.dist(start, end) < MIN_LENGTH_M:
                following = number % len(self.points_m) + 1
                problem = f"the points {number} and {following} of points_m are at the same place"
                raise Mistake(problem, "Remove one of them", kind="same-point")
        return self

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The straight parts of the line, from the first point on."""
        return tuple(pairwise((*self.points_m, *self.points_m[: int(self.closed)])))

    @property
    def outlines(self) -> tuple[tuple[tuple[float, float], ...], ...]:
        """The outline of each segment with its round ends: a convex polygon, counter-clockwise, in metres."""
        return tuple(_outline(segment, self.width_m / 2) for segment in self.segments)


def _outline(segment: Segment, radius: float) -> tuple[tuple[float, float], ...]:
    (start_x, start_y), (end_x, end_y) = segment
    ahead = math.atan2(end_y - start_y, end_x - start_x)
    turns = [math.pi * (step / _ARC_STEPS - 0.5) for step in range(_ARC_STEPS + 1)]
    ends = ((end_x, end_y, ahead), (start_x, start_y, ahead + math.pi))
    return tuple(
        (x + radius * math.cos(facing + turn), y + radius * math.sin(facing + turn))
        for x, y, facing in ends
        for turn in turns
    )


class LineDistances:
    """Measures distances to the polyline in the middle of a line. ``length`` is its length in metres."""

    def __init__(self, line: Line) -> None:
        segments = np.array(line.segments)
        self._starts, self._ways = segments[:, 0], segments[:, 1] - segments[:, 0]
        self._squares = (self._ways**2).sum(axis=1)
        lengths = np.sqrt(self._squares)
        self.length = float(lengths.sum())
        self._lengths, self._begins = lengths, np.cumsum(lengths) - lengths

    def measure(self, points: Array) -> Array:
        """Return the distance of each point, (n, 2), from the nearest point of the polyline, (n,), in metres."""
        distances, _ = self._project(points)
        return np.asarray(distances.min(axis=1))

    def locate(self, x: float, y: float) -> tuple[float, float]:
        """Return the distance of a point from the polyline, and how far along it the nearest point is."""
        (distances,), (along,) = self._project(np.array([(x, y)]))
        nearest = int(distances.argmin())
        return float(distances[nearest]), float(self._begins[nearest] + along[nearest] * self._lengths[nearest])

    def _project(self, points: Array) -> tuple[Array, Array]:
        """Return the distance of n points from m segments, and the part of each segment before the nearest point."""
        gaps = points[:, None] - self._starts
        along = np.clip((gaps * self._ways).sum(axis=2) / self._squares, 0.0, 1.0)
        return np.asarray(np.linalg.norm(gaps - along[..., None] * self._ways, axis=2)), along
