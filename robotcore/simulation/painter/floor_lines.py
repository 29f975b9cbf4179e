"""Project the lines on the floor of a world."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from robotcore.description import Line
from robotcore.optics import CameraView
from robotcore.simulation.painter.canvas import Palette, PixelBuffer
from robotcore.simulation.painter.planes import Array
from robotcore.simulation.painter.projection import PolygonSet
from robotcore.simulation.painter.rasterizing import Area


class LineMark(NamedTuple):
    """A segment of a line as the camera sees it."""

    area: Area
    line: int
    """The number of the line."""

    def paint(self, canvas: PixelBuffer, palette: Palette) -> None:
        self.area.fill(canvas, palette.lines[self.line])


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
        for segment, area in self._polygons.project(view, is_above):
            yield LineMark(area, self._numbers[segment])
