"""Draw the picture and the lines on the floor of a world as one texture, for simulators that draw textures."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from robotcore.description import WorldDescription
from robotcore.description.floor_colours import FloorColours
from robotcore.description.meshes import Rectangle
from robotcore.description.png import Pixels
from robotcore.simulation.painter.rasterizing import rasterize

TEXEL_M = 0.001
"""The least width of a texel on the floor, in metres."""

MAX_TEXELS, MAX_SIDE = 2**22, 8192
"""The greatest numbers of texels of a sheet and along one of its sides. On a large sheet, texels are wider."""

_STRIP_TEXELS = 2**18
"""The number of texels whose colours are computed at once, so that the arrays take little memory."""


class FloorSheet(NamedTuple):
    """A rectangle of the floor with its picture and its lines. At its edges it has the colours of the plain floor."""

    rectangle: Rectangle
    hole: Rectangle
    """The part of the ground that the sheet replaces. It is smaller than the sheet by half a texel on each side.

    So there is no gap between the ground and the sheet. Where both are drawn, they have the same colours.
    """
    pixels: Pixels
    """Red, green and blue without the light, (rows, columns, 3), from 0 to 255. The first row is at the least y."""


def draw_floor_sheet(world: WorldDescription) -> FloorSheet | None:
    """Return the sheet of a world; None for a world without a picture and without lines on its floor."""
    if not (world.lines or world.floor.image):
        return None
    left, bottom, right, top = _find_limits(world)
    length, width = right - left, top - bottom
    texel = max(TEXEL_M, math.sqrt(length * width / MAX_TEXELS), max(length, width) / MAX_SIDE)
    columns, rows = (math.ceil(side / texel) + 2 for side in (length, width))  # one more texel on each side
    left, bottom = left - texel, bottom - texel
    rectangle = left, bottom, left + columns * texel, bottom + rows * texel
    inward = (texel / 2, texel / 2, -texel / 2, -texel / 2)
    pixels = _draw_ground(world, left + texel * (np.arange(columns) + 0.5), bottom + texel * (np.arange(rows) + 0.5))
    _draw_lines(world, pixels, texel, (left, bottom))
    return FloorSheet(rectangle, _add(rectangle, inward), pixels)


def _find_limits(world: WorldDescription) -> Rectangle:
    points = [point for line in world.lines for outline in line.outlines for point in outline]
    if image := world.floor.image:
        points += [image.limits[:2], image.limits[2:]]
    (left, bottom), (right, top) = np.min(points, axis=0).tolist(), np.max(points, axis=0).tolist()
    return left, bottom, right, top


def _add(one: Rectangle, other: Rectangle) -> Rectangle:
    left, bottom, right, top = map(sum, zip(one, other, strict=True))
    return left, bottom, right, top


def _draw_ground(world: WorldDescription, xs: np.ndarray, ys: np.ndarray) -> Pixels:
    """Return the colours of the floor without its lines at places in a grid."""
    pixels = np.full((len(ys), len(xs), 3), world.floor.colour, dtype=np.uint8)
    if world.floor.image or world.floor.texture:
        colours = FloorColours(world.model_copy(update={"lines": ()}))
        step = max(_STRIP_TEXELS // len(xs), 1)
        for first in range(0, len(ys), step):
            points = np.stack(np.meshgrid(xs, ys[first : first + step]), axis=-1).reshape(-1, 2)
            pixels[first : first + step] = np.rint(colours.measure(points)).reshape(-1, len(xs), 3)
    return pixels


def _draw_lines(world: WorldDescription, pixels: Pixels, texel: float, origin: Iterable[float]) -> None:
    """Draw the lines on a sheet.

    texel: the width of a texel, in metres.
    origin: the place of the sheet's corner with the least x and the least y, in metres.
    """
    numbers = np.zeros(pixels.shape[:2], dtype=np.uint32)
    for number, line in enumerate(world.lines, start=1):
        for outline in line.outlines:
            corners = (np.array(outline) - origin) / texel - 0.5
            area = rasterize(corners[:, 0].tolist(), corners[:, 1].tolist(), pixels.shape[1], pixels.shape[0])
            area.fill(numbers, number)
    colours = np.array([(0, 0, 0), *(line.colour for line in world.lines)], dtype=np.uint8)
    is_line = numbers > 0
    pixels[is_line] = colours[numbers[is_line]]
