"""Project the lines on the floor of a world."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robotcore.description import Line
from robotcore.optics import CameraView
from robotcore.simulation.painter.canvas import Palette, PixelBuffer, fill
from robotcore.simulation.painter.planes import Array
from robotcore.simulation.painter.projection import Polygon, PolygonSet


@dataclass(frozen=True)
class LineMark:
    """A segment of a line as the camera sees it.

    ``polygon`` holds the corners in pixels, clockwise. ``line`` is the number of the line.
    """

    polygon: Polygon
    line: int

    def paint(self, canvas: PixelBuffer, palette: Palette) -> None:
        fill(canvas, self.polygon, palette.lines[self.line])


class FloorLines:
    """The lines on the floor.

    ``colours`` holds red, green and blue of each line, (n, 3). ``zeros`` holds a 0 for each line.
    """

    def __init__(self, lines: Sequence[Line]) -> None:
        self.colours: Array = np.array([line.colour for line in lines], dtype=np.float64).reshape(-1, 3)
        self.zeros = [0] * len(lines)
        outlines = [(number, outline) for number, line in enumerate(lines) for outline in line.outlines]
        self._numbers = [number for number, _ in outlines]
        # From above, the corners are clockwise in the picture.
        self._polygons = PolygonSet([np.array([(x, y, 0.0) for x, y in reversed(each)]) for _, each in outlines])

    def marks(self, view: CameraView) -> Iterator[LineMark]:
        """Yield the segments that the picture shows, in the order of painting."""
        is_above = np.full(len(self._numbers), view.eye[2] > 0)
        for segment, polygon in self._polygons.project(view, is_above):
            yield LineMark(polygon, self._numbers[segment])
