"""Paints patterns on the ground and on faces. For each pixel it computes the texel that the ray meets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import count

import numpy as np
from numpy.typing import NDArray

from robotcore.description import WorldDescription
from robotcore.description.meshes import face_wrap, floor_wrap
from robotcore.description.texture import TILE_PX
from robotcore.optics import CameraView
from robotcore.simulation.painter.canvas import Canvas, shade_colours
from robotcore.simulation.painter.faces import Block, Faces, Facet

UP = (0.0, 0.0, 1.0)

VANISHED_PX, FADING_PX = 2.0, 6.0
"""A tile narrower than VANISHED_PX shows its mean only. From FADING_PX more on, it shows its full contrast."""

EDGE_ON = -1e-3
"""A limit on the slope that bounds a division. Surfaces beyond it are so edge-on that no pixel shows them."""

WINDOW_PX = 8192
"""The most pixels of a window, so that its arrays stay in the processor's cache."""

Singles = NDArray[np.float32]
Window = tuple[slice, slice]


class Texturing:
    """Paints the patterns of the ground and of faces that have one.

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
        self._shades = shade_colours(colours, self._normals @ np.array(world.light.direction), world.light)
        self._axes = TILE_PX * np.array([wrap.axes for wrap in wraps]).reshape(-1, 2, 3)
        self._shifts = TILE_PX * np.array([wrap.shift for wrap in wraps]).reshape(-1, 2)
        self._scales = np.array([wrap.texture.scale_m for wrap in wraps])
        tiles = {wrap.texture: wrap.texture.tile.reshape(-1).astype(np.float32) for wrap in wraps}
        self._tiles = [tiles[wrap.texture] for wrap in wraps]

    @property
    def is_needed(self) -> bool:
        return any(self.numbers)

    def paint(self, canvas: Canvas, numbers: Canvas, view: CameraView, facets: Iterable[Facet]) -> None:
        """Paint the patterns of the ground and of these facets.

        ``numbers`` has for each pixel of the canvas the number of the surface that it shows, or 0.
        """
        maps, sharpness = self._seen_from(view)
        for number, window in self._windows(facets, canvas.shape):
            is_shown = numbers[window] == number
            if is_shown.any():
                at = number - 1
                levels = _levels(maps[at], sharpness[at], self._tiles[at], window)
                np.copyto(canvas[window], self._shades[at].take(levels), where=is_shown)

    def _windows(self, facets: Iterable[Facet], size: tuple[int, ...]) -> Iterator[tuple[int, Window]]:
        """Yield the numbers of surfaces that may be visible, and their windows."""
        height, width = size
        ground, *faces = self.numbers
        boxes = [(ground, (0.0, 0.0, width, height)), *((faces[facet.face], facet.box) for facet in facets)]
        for number, (left, top, right, bottom) in boxes:
            columns = slice(max(math.ceil(left), 0), min(math.floor(right) + 1, width))
            rows = range(max(math.ceil(top), 0), min(math.floor(bottom) + 1, height))
            if number and columns.stop > columns.start:
                step = max(WINDOW_PX // (columns.stop - columns.start), 1)
                for first in rows[::step]:
                    yield number, (slice(first, min(first + step, rows.stop)), columns)

    def _seen_from(self, view: CameraView) -> tuple[Singles, Singles]:
        """Return for each surface the maps from pixels (u, v) to texels, (n, 3, 3), and the sharpness, (n,).

        A ray e + t·d meets the plane n·p = o at t = k / n·d where k = o - n·e. Its place there, a·p + s, is
        ((a·e + s) n·d + k a·d) / n·d, of which all parts are linear in the pixel. From one pixel to the next it moves
        by up to k f / (n·d)², f being the focal length.
        """
        i = view.intrinsics
        from_pixel = np.array(((1, 0, -i.cx), (0, 1, -i.cy), (0, 0, i.focal_length)))
        slopes = (self._normals @ view.rotation.T @ from_pixel)[:, None]
        gaps = self._offsets - self._normals @ view.eye
        places = self._axes @ view.eye + self._shifts
        ways = places[..., None] * slopes + gaps[:, None, None] * (self._axes @ view.rotation.T @ from_pixel)
        pixels = self._scales / np.maximum(-gaps, 1e-9) / i.focal_length
        return np.concatenate((ways, slopes), axis=1).astype(np.float32), (pixels / FADING_PX).astype(np.float32)


def _levels(maps: Singles, sharpness: np.float32, tile: Singles, window: Window) -> NDArray[np.intp]:
    """Return the factor of a pattern on its colour, times 255, at the pixels of a window."""
    rows, columns = window
    u = np.arange(columns.start, columns.stop, dtype=np.float32)
    v = np.arange(rows.start, rows.stop, dtype=np.float32)[:, None]
    along, up, slope = (a * u + (b * v + c) for a, b, c in maps)
    np.minimum(slope, EDGE_ON, out=slope)
    column, row = (np.floor(way / slope).astype(np.intp) & (TILE_PX - 1) for way in (along, up))
    texels = tile.take(row * TILE_PX + column)
    contrast = np.clip(slope * slope * sharpness - VANISHED_PX / FADING_PX, 0.0, 1.0)
    mean = tile.mean()
    return np.asarray(mean + contrast * (texels - mean), dtype=np.intp)
