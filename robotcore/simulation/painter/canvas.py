"""The canvas: shades colours, packs them as 32-bit inks, and fills convex polygons with them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Light
from robotcore.simulation.painter.planes import Array

Canvas = NDArray[np.uint32]
"""A picture with 32 bits a pixel, (height, width).

A pixel holds either an ink or the number of a body. The bytes of an ink are blue, green, red and an unused byte.
"""


class Palette(NamedTuple):
    """The inks of a world. A ball has several: from parts that the lamp only grazes to parts that face the lamp."""

    sky: int
    ground: int
    faces: Sequence[int]
    balls: Mapping[int, NDArray[np.uint32]]


class Stroke(Protocol):
    """A face or a part of a ball in a picture.

    ``columns`` are the first and the last column that the stroke may cover. ``part`` is the number of the stroke's
    block or ball. The numbers of balls follow those of blocks.
    """

    @property
    def part(self) -> int: ...
    @property
    def columns(self) -> tuple[float, float]: ...
    def paint(self, canvas: Canvas, palette: Palette) -> None: ...


Inks = NDArray[np.uint32]

RAMP_STEPS = 1024
SHADES = 256


def shade_inks(colours: Array, cosines: Array, light: Light) -> Inks:
    """Return the inks of faces, (n,).

    colours: red, green and blue of each face, (n, 3).
    cosines: the cosine of the angle between each face's normal and the lamp, (n,).
    """
    shade = np.minimum(light.ambient + light.diffuse * np.maximum(cosines, 0.0), 1.0) * light.brightness
    return pack_inks(colours * shade[:, None])


def shade_colours(colours: Array, cosines: Array, light: Light) -> Inks:
    """Return the inks of faces like `shade_inks`, but for each face in SHADES steps from black to its full colour.

    The shape is (n, SHADES).
    """
    parts = np.linspace(0.0, 1.0, SHADES)[:, None]
    darkened = (colours[:, None] * parts).reshape(-1, 3)
    return shade_inks(darkened, np.repeat(cosines, SHADES), light).reshape(-1, SHADES)


def shade_ramp(colour: tuple[int, int, int], light: Light) -> Inks:
    """Return the inks of one colour for a surface that turns from edge-on to the lamp to facing it, (RAMP_STEPS,)."""
    return shade_inks(np.full((RAMP_STEPS, 3), colour, dtype=np.float64), np.linspace(0.0, 1.0, RAMP_STEPS), light)


def pack_inks(colours: Array) -> Inks:
    """Return colours as inks, (n,). The colours are red, green and blue, (n, 3). Values above 255 count as 255."""
    pixels = np.zeros((len(colours), 4), dtype=np.uint8)
    pixels[:, :3] = np.rint(np.minimum(colours, 255.0))[:, ::-1]
    return pixels.view(np.uint32)[:, 0]


Point = Sequence[float]

SEAM = 1e-6
"""Neighbouring polygons overlap by this fraction of a pixel, so that rounding leaves no gap between them.

Horizontal edges are moved inwards by the same distance, so that each row crosses the left and the right flank.
"""


def fill(canvas: NDArray[np.uint32], polygon: Sequence[Point], ink: int) -> None:
    """Fill a convex polygon with an ink. The corners, (u, v), are clockwise in the picture.

    `cv2.fillConvexPoly` is not exact enough, because it paints half a pixel beyond each edge.
    """
    columns, rows = (
        _span(axis, size) for axis, size in zip(zip(*polygon, strict=True), canvas.shape[::-1], strict=True)
    )
    if len(columns) < len(rows):
        _fill_lines(canvas.T, [(v, u) for u, v in reversed(polygon)], columns, ink)
    else:
        _fill_lines(canvas, polygon, rows, ink)


def _span(places: Sequence[float], size: int) -> range:
    """Return the rows, or columns, of the canvas between the least and the greatest of some coordinates."""
    return range(max(math.ceil(min(places)), 0), min(math.floor(max(places)), size - 1) + 1)


def _fill_lines(canvas: NDArray[np.uint32], polygon: Sequence[Point], lines: range, ink: int) -> None:
    if not lines:
        return
    heights = [v for _, v in polygon]
    levels = np.clip(np.arange(lines.start, lines.stop, dtype=np.float64), min(heights) + SEAM, max(heights) - SEAM)
    left, right = _flanks(polygon, heights)
    bounds = np.stack((_along(left, levels) - SEAM, _along(right, levels) + SEAM))
    begins, ends = np.clip(np.ceil(bounds), 0, canvas.shape[1]).astype(np.intp).tolist()
    for line, begin, end in zip(canvas[lines.start : lines.stop], begins, ends, strict=True):
        line[begin:end] = ink


def _flanks(polygon: Sequence[Point], heights: list[float]) -> tuple[Sequence[Point], Sequence[Point]]:
    """Return the corners of a polygon's left flank and those of its right flank, both from top to bottom."""
    top = heights.index(min(heights))
    ring = [*polygon[top:], *polygon[: top + 1]]
    bottom = (heights.index(max(heights)) - top) % len(polygon)
    return ring[bottom:][::-1], ring[: bottom + 1]


def _along(flank: Sequence[Point], levels: NDArray[np.float64]) -> NDArray[np.float64]:
    columns, heights = zip(*flank, strict=True)
    return np.asarray(np.interp(levels, heights, columns))
