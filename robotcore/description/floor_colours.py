"""The colour of the floor of a world at a point, with its texture, picture and lines, and without the light."""

from __future__ import annotations

import numpy as np

from robotcore.description.lines import Array, LineDistances
from robotcore.description.meshes import floor_wrap
from robotcore.description.texture import TILE_PX
from robotcore.description.world import WorldDescription


class FloorColours:
    """The colours of the floor of a world.

    >>> from robotcore.description import load_world
    >>> FloorColours(load_world("open")).measure(np.array([(0.5, 0.2)])).tolist()
    [[190.0, 185.0, 175.0]]
    """

    def __init__(self, world: WorldDescription) -> None:
        self._colour = np.array(world.floor.colour, dtype=np.float64)
        self._wrap = floor_wrap(world.floor)
        self._tile = self._wrap.texture.tile / 255 if self._wrap else None
        self._image = world.floor.image
        self._picture = self._image.render(world.floor.colour) if self._image else None
        self._lines = [(LineDistances(line), line.width_m / 2, line.colour) for line in world.lines]

    def measure(self, points: Array) -> Array:
        """Return red, green and blue, from 0 to 255, of points of the world, (n, 2) in metres. The result is (n, 3)."""
        colours = np.tile(self._colour, (len(points), 1))
        if self._wrap and self._tile is not None:
            texels = self._wrap.tiles(np.column_stack((points, np.zeros(len(points))))) * TILE_PX
            columns, rows = np.floor(texels).astype(np.intp).T & (TILE_PX - 1)
            colours *= self._tile[rows, columns][:, None]
        if self._image and self._picture is not None:
            is_inside, row, column = self._image.locate(points)
            colours[is_inside] = self._picture[row, column]
        for distances, half_width, colour in self._lines:
            colours[distances.measure(points) <= half_width] = colour
        return colours
