"""The patterns on floors, walls and obstacles, as repeated tiles of brightness."""

from __future__ import annotations

from functools import cache
from random import Random
from typing import Annotated, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from robotcore.description.types import StrictModel

TILE_PX = 64
"""The width and the height of a tile in pixels: a power of two, so that a renderer can repeat it with a bit mask."""

Pattern = Literal["plain", "checker", "planks", "speckle", "grass"]
PATTERNS: tuple[Pattern, ...] = get_args(Pattern)
TileSize = Annotated[float, Field(ge=0.01, le=100)]
Contrast = Annotated[float, Field(ge=0, le=0.9)]

Depths = NDArray[np.float64]
Tile = NDArray[np.uint8]


class Texture(StrictModel):
    """A pattern that is repeated on a surface and darkens the surface's colour.

    >>> Texture(pattern="checker", contrast=0.5).tile[0, [0, -1]]
    array([255, 128], dtype=uint8)
    """

    pattern: Pattern
    scale_m: TileSize = 0.25
    """The width and the height of a tile on the surface, in metres."""
    contrast: Contrast = 0.3
    """The part of the brightness that the surface loses at the darkest pixels of the pattern, from 0 to 0.9."""

    @property
    def tile(self) -> Tile:
        """The factors by which the surface's colour is multiplied, times 255, shape (TILE_PX, TILE_PX).

        The first row is at the bottom of the tile.
        """
        return np.rint(255 * (1 - self.contrast * _make_depths(self.pattern))).astype(np.uint8)


@cache
def _make_depths(pattern: Pattern) -> Depths:
    """Return the darkness of each pixel of a pattern, from 0 to 1 for the full contrast."""
    match pattern:
        case "plain":
            return np.zeros((TILE_PX, TILE_PX))
        case "checker":
            return _enlarge(np.array(((0.0, 1.0), (1.0, 0.0))))
        case "planks":
            boards = 0.6 * _make_grain("planks", 8, 1)
            boards[:: TILE_PX // 8] = 1.0
            return boards
        case "speckle":
            return np.asarray(0.6 * _make_grain("fine", 32, 32) + 0.4 * _make_grain("coarse", 16, 16))
        case "grass":
            return np.asarray(0.7 * _make_grain("blades", 8, 64) + 0.3 * _make_grain("patches", 8, 8))


def _make_grain(name: str, rows: int, columns: int) -> Depths:
    random = Random(name)
    return _enlarge(np.array([[random.random() for _ in range(columns)] for _ in range(rows)]))


def _enlarge(cells: Depths) -> Depths:
    rows, columns = cells.shape
    return np.repeat(np.repeat(cells, TILE_PX // rows, axis=0), TILE_PX // columns, axis=1)
