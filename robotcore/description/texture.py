"""The patterns of floors and walls, as tiles of brightness."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from random import Random
from typing import Annotated, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from robotcore.description.types import StrictModel

TILE_PX = 64
"""Of a tile, which is square; a power of two, so that a renderer wraps round with a mask."""

Pattern = Literal["plain", "checker", "planks", "speckle", "grass"]
PATTERNS: tuple[Pattern, ...] = get_args(Pattern)
TileSize = Annotated[float, Field(ge=0.01, le=100)]
Contrast = Annotated[float, Field(ge=0, le=0.9)]

Depths = NDArray[np.float64]
Tile = NDArray[np.uint8]


class Texture(StrictModel):
    """A pattern that repeats every ``scale_m`` and takes up to ``contrast`` of the colour's brightness away."""

    pattern: Pattern
    scale_m: TileSize = 0.25
    contrast: Contrast = 0.3

    @property
    def tile(self) -> Tile:
        """What is left of the colour, in 255ths, (TILE_PX, TILE_PX): rows go up the surface, columns along it."""
        return np.rint(255 * (1 - self.contrast * _depths(self.pattern))).astype(np.uint8)


@cache
def _depths(pattern: Pattern) -> Depths:
    """Return which part of its contrast a pattern takes away where, (TILE_PX, TILE_PX)."""
    return _PATTERNS[pattern]()


def _plain() -> Depths:
    return np.zeros((TILE_PX, TILE_PX))


def _checker() -> Depths:
    """Two squares by two."""
    return _enlarged(np.array(((0.0, 1.0), (1.0, 0.0))))


def _planks() -> Depths:
    """Eight boards, each of its own shade, with dark joints."""
    boards = 0.6 * _grain("planks", 8, 1)
    boards[:: TILE_PX // 8] = 1.0
    return boards


def _speckle() -> Depths:
    """Grain of two sizes."""
    return np.asarray(0.6 * _grain("fine", 32, 32) + 0.4 * _grain("coarse", 16, 16))


def _grass() -> Depths:
    """Narrow blades over patches."""
    return np.asarray(0.7 * _grain("blades", 8, 64) + 0.3 * _grain("patches", 8, 8))


_PATTERNS: dict[Pattern, Callable[[], Depths]] = {
    "plain": _plain,
    "checker": _checker,
    "planks": _planks,
    "speckle": _speckle,
    "grass": _grass,
}


def _grain(name: str, rows: int, columns: int) -> Depths:
    """Return a tile of cells of random depth; the name always gives the same ones."""
    random = Random(name)
    return _enlarged(np.array([[random.random() for _ in range(columns)] for _ in range(rows)]))


def _enlarged(cells: Depths) -> Depths:
    rows, columns = cells.shape
    return np.repeat(np.repeat(cells, TILE_PX // rows, axis=0), TILE_PX // columns, axis=1)
