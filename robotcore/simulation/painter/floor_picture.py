"""Paint the picture on the floor of a world into the picture of a camera.

For each pixel of the camera, the mark computes the pixel on the floor that the camera's ray meets.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robotcore.description import FloorImage
from robotcore.optics import CameraView
from robotcore.simulation.painter.canvas import Palette, PixelBuffer
from robotcore.simulation.painter.planes import Array
from robotcore.simulation.painter.projection import PolygonSet
from robotcore.simulation.painter.texturing import EDGE_ON


@dataclass(frozen=True, eq=False)
class PictureMark:
    """The picture on the floor as the camera sees it.

    ``box`` holds the left, top, right and bottom edge of its bounding box, in pixels of the camera. ``mapping`` maps a
    pixel (u, v, 1) of the camera to a point of the picture in homogeneous coordinates, (3, 3). The picture reaches from
    0 to 1 along both axes.
    """

    box: tuple[float, ...]
    mapping: Array

    def paint(self, canvas: PixelBuffer, palette: Palette) -> None:
        left, top, right, bottom = self.box
        rows, columns = (
            slice(max(math.ceil(first), 0), max(min(math.floor(last) + 1, size), 0))
            for first, last, size in zip((top, left), (bottom, right), canvas.shape, strict=True)
        )
        height, width = palette.picture.shape
        u = np.arange(columns.start, columns.stop, dtype=np.float32)
        v = np.arange(rows.start, rows.stop, dtype=np.float64)[:, None]
        across, down, (along_u, along_v, rest) = self.mapping * ((width,), (height,), (1,))
        slope = along_v * v + rest
        if along_u:  # the camera rolls, so the slope is not that of a whole row
            slope = slope + along_u * u
        slope = np.minimum(slope, EDGE_ON)
        column, row = (
            (a / slope).astype(np.float32) * u + ((b * v + c) / slope).astype(np.float32) for a, b, c in (across, down)
        )
        is_inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        pixels = row.astype(np.int32) * width + column.astype(np.int32)
        np.copyto(canvas[rows, columns], palette.picture.take(pixels, mode="clip"), where=is_inside)


class FloorPicture:
    """The place of the picture on the floor."""

    def __init__(self, image: FloorImage | None) -> None:
        self._polygons = PolygonSet([])
        if image:
            left, bottom, right, top = image.limits
            # From above, the corners are clockwise in the picture.
            corners = ((left, top, 0.0), (right, top, 0.0), (right, bottom, 0.0), (left, bottom, 0.0))
            self._polygons = PolygonSet([np.array(corners)])
            self._axes = np.array(((1 / image.length_m, 0.0, 0.0), (0.0, -1 / image.width_m, 0.0)))
            self._shift = -self._axes @ (left, top, 0.0)

    def marks(self, view: CameraView) -> Iterator[PictureMark]:
        """Yield the picture if the camera sees it."""
        for _, area in self._polygons.project(view, np.array([view.eye[2] > 0])):
            yield PictureMark(tuple(area.box), self._compute_mapping(view))

    def _compute_mapping(self, view: CameraView) -> Array:
        """Return the mapping of a mark. `Texturing` has the derivation, for any plane."""
        i = view.intrinsics
        rays = view.rotation.T @ np.array(((1, 0, -i.cx), (0, 1, -i.cy), (0, 0, i.focal_length)))
        place = self._axes @ view.eye + self._shift
        return np.vstack((np.outer(place, rays[2]) - view.eye[2] * (self._axes @ rays), rays[2]))
