"""Patterns on the ground and on faces: every pixel asks where on a tile its ray meets their plane."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count

import numpy as np
from numpy.typing import NDArray

from drivers.kinematic.painter.blocks import Block
from drivers.kinematic.painter.canvas import Canvas
from drivers.kinematic.painter.faces import Faces
from drivers.kinematic.painter.shading import SHADES, shades_of
from robotcore.description import Texture, WorldDescription
from robotcore.description.texture import TILE_PX
from robotcore.description.wraps import face_wrap, floor_wrap
from robotcore.projection import View

UP = (0.0, 0.0, 1.0)

VANISHED_PX, FADING_PX = 2.0, 6.0
"""A tile that takes fewer pixels shows its mean only; one that takes so many more, all of its contrast."""

EDGE_ON = -1e-3
"""What is seen more edge-on shows in no pixel; this keeps the division within bounds."""

Singles = NDArray[np.float32]
Seen = tuple[Singles, Singles, Singles, Singles]
Places = NDArray[np.intp]

BAND_ROWS = 32
"""What is reckoned for each pixel stays in the processor's cache."""


class Texturing:
    """Paints the patterns of the ground and of faces, where they have one.

    ``numbers`` are those of the surfaces that have a pattern, from 1, for the ground and then each face; 0 is none.
    """

    def __init__(self, world: WorldDescription, blocks: Sequence[Block], faces: Faces) -> None:
        things = [world.prisms[blocks[owner].thing] for owner in faces.owners]
        every = [floor_wrap(world.floor), *map(face_wrap, things, faces.normals)]
        wraps = [wrap for wrap in every if wrap]
        number = count(1)
        self.numbers = [next(number) if wrap else 0 for wrap in every]
        surfaces = np.flatnonzero(self.numbers)
        self._normals = np.vstack((UP, faces.normals))[surfaces]
        self._offsets = np.array((0.0, *faces.offsets))[surfaces]
        colours = np.vstack((world.floor.colour, faces.colours))[surfaces]
        cosines = self._normals @ np.array(world.light.direction)
        self._shades = shades_of(colours, cosines, world.light).reshape(-1)
        self._axes = TILE_PX * np.array([wrap.axes for wrap in wraps]).reshape(-1, 2, 3)
        self._shifts = TILE_PX * np.array([wrap.shift for wrap in wraps]).reshape(-1, 2)
        self._scales = np.array([wrap.texture.scale_m for wrap in wraps])
        self._take_tiles([wrap.texture for wrap in wraps])

    def _take_tiles(self, textures: Sequence[Texture]) -> None:
        """Keep one tile of each sort, one after the other, and which one each surface has."""
        sorts = list(dict.fromkeys(textures))
        tiles = np.array([texture.tile for texture in sorts], dtype=np.float32).reshape(-1, TILE_PX, TILE_PX)
        self._tiles = tiles.reshape(-1)
        self._tile_of = np.array([sorts.index(texture) for texture in textures], dtype=np.intp)
        self._means = tiles.mean(axis=(1, 2))[self._tile_of]

    @property
    def is_needed(self) -> bool:
        return any(self.numbers)

    def paint(self, canvas: Canvas, numbers: Canvas, view: View) -> None:
        """Paint the pixels that show a surface; ``numbers`` has for each that surface's number from 1, or 0."""
        seen = self._seen_from(view)
        for top in range(0, len(canvas), BAND_ROWS):
            band = slice(top, top + BAND_ROWS)
            if (is_shown := numbers[band] > 0).any():
                surface = numbers[band].astype(np.intp) - 1
                shades = self._shades.take(surface * SHADES + self._levels(seen, surface, top))
                np.copyto(canvas[band], shades, where=is_shown)

    def _levels(self, seen: Seen, surface: Places, top: int) -> Places:
        """Return what each pixel's pattern leaves of its colour, in 255ths, for rows from ``top`` on."""
        height, width = surface.shape
        u, v = np.arange(width, dtype=np.float32), np.arange(top, top + height, dtype=np.float32)[:, None]
        *maps, sharpness = seen
        along, up, slope = (a.take(surface) * u + (b.take(surface) * v + c.take(surface)) for a, b, c in maps)
        np.minimum(slope, EDGE_ON, out=slope)
        column, row = (np.floor(way / slope).astype(np.intp) & (TILE_PX - 1) for way in (along, up))
        texels = self._tiles.take((self._tile_of.take(surface) * TILE_PX + row) * TILE_PX + column)
        contrast = np.clip(slope * slope * sharpness.take(surface) - VANISHED_PX / FADING_PX, 0, 1)
        means = self._means.take(surface)
        return np.asarray(means + contrast * (texels - means), dtype=np.intp)

    def _seen_from(self, view: View) -> Seen:
        """Return for all surfaces how pixels (u, v) map to texels, three times (3, n), and how sharp, (n,).

        A ray e + t·d meets the plane n·p = o at t = k / n·d where k = o - n·e. Its place there, a·p + s, is
        ((a·e + s) n·d + k a·d) / n·d, of which all parts are linear in the pixel. From one pixel to the next it moves
        by up to k f / (n·d)², f being the focal length.
        """
        i = view.intrinsics
        from_pixel = np.array(((1, 0, -i.cx), (0, 1, -i.cy), (0, 0, i.focal_length)))
        slopes = self._normals @ view.rotation.T @ from_pixel
        gaps = self._offsets - self._normals @ view.eye
        places = self._axes @ view.eye + self._shifts
        ways = places[..., None] * slopes[:, None] + gaps[:, None, None] * (self._axes @ view.rotation.T @ from_pixel)
        pixels = self._scales / np.maximum(-gaps, 1e-9) / i.focal_length
        maps = (ways[:, 0].T, ways[:, 1].T, slopes.T, pixels / FADING_PX)
        along, up, slope, sharpness = (np.ascontiguousarray(part, dtype=np.float32) for part in maps)
        return along, up, slope, sharpness
