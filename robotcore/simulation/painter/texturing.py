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
"""A tile that is narrower than VANISHED_PX in the picture shows only its mean brightness.

Its contrast grows with its width. A tile of at least VANISHED_PX + FADING_PX has its full contrast.
"""

EDGE_ON = -1e-3
"""A limit on a surface's slope, so that no division is by almost 0. A surface at the limit is too edge-on to see."""

WINDOW_PX = 8192
"""The greatest number of pixels in a window. The arrays of such a window stay in the processor's cache."""

Singles = NDArray[np.float32]
Window = tuple[slice, slice]


class Texturing:
    """Paints the patterns of the ground and of faces that have one.

    ``numbers`` holds a number for the ground, and then one for each face. Surfaces that have a pattern are numbered
    from 1 on. A surface without a pattern has the number 0.
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

        ``numbers`` holds for each pixel of the canvas the number of the surface that the pixel shows, or 0.
        """
        maps, sharpness = self._seen_from(view)
        for number, window in self._windows(facets, canvas.shape):
            is_shown = numbers[window] == number
            if is_shown.any():
                at = number - 1
                levels = _levels(maps[at], sharpness[at], self._tiles[at], window)
                np.copyto(canvas[window], self._shades[at].take(levels), where=is_shown)

    def _windows(self, facets: Iterable[Facet], size: tuple[int, ...]) -> Iterator[tuple[int, Window]]:
        """Yield the number and the windows of each surface that may be visible. A window is a part of the picture."""
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
        """Return for each surface the map from pixels (u, v) to texels, (n, 3, 3), and the sharpness, (n,).

        The sharpness times (n·d)² is the width of a tile in the picture, in units of `FADING_PX`. A ray e + t·d meets
        the plane n·p = o at t = k / n·d with k = o - n·e. The texel there is a·p + s = ((a·e + s) n·d + k a·d) / n·d.
        Numerator and denominator are linear in the pixel. From one pixel to the next, the point moves on the surface
        by up to k f / (n·d)², with the focal length f.
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
    """Return for each pixel of a window the factor by which a pattern darkens the surface's colour, times 255."""
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
