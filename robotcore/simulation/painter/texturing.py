"""Paint patterns on the ground and on faces: compute for each pixel the texel that its ray meets."""

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
from robotcore.simulation.painter.canvas import PixelBuffer, shade_in_steps
from robotcore.simulation.painter.faces import Block, Faces, Facet

UP = (0.0, 0.0, 1.0)

VANISHED_PX, FADING_PX = 2.0, 6.0
"""The contrast of a tile of a pattern depends on the tile's width in the picture, in pixels.

Up to VANISHED_PX, the tile shows only its mean brightness. From VANISHED_PX + FADING_PX on, it has its full contrast.
"""

EDGE_ON = -1e-3
"""The greatest value of n·d, for a surface's normal n and a ray d. A greater value would divide by almost 0.

A surface at this limit is edge-on to the ray, so that the camera cannot see it.
"""

WINDOW_PX = 8192
"""The greatest number of pixels of a window, which is a rectangle of the picture that is painted at once.

It is so small that a window's arrays stay in the processor's cache.
"""

MAX_TEXEL = 2.0**30
"""The greatest magnitude of a texel's row or column. A farther texel belongs to a tile that shows its mean only."""

Singles = NDArray[np.float32]

NUMBERS: Singles = np.arange(2**14, dtype=np.float32)
"""The numbers of rows and columns."""

Window = tuple[slice, slice]


class Texturing:
    """Paints the patterns of the ground and of faces.

    ``numbers`` holds a number for the ground, and then one for each face. Surfaces with a pattern have numbers from 1
    on. Surfaces without a pattern have the number 0.
    """

    def __init__(self, world: WorldDescription, blocks: Sequence[Block], faces: Faces) -> None:
        all_prisms = world.prisms
        prisms = [all_prisms[blocks[number].prism_index] for number in faces.block_numbers]
        every = [floor_wrap(world.floor), *map(face_wrap, prisms, faces.normals)]
        wraps = [wrap for wrap in every if wrap]
        number = count(1)
        self.numbers = [next(number) if wrap else 0 for wrap in every]
        surfaces = np.flatnonzero(self.numbers)
        self._normals = np.vstack((UP, faces.normals))[surfaces]
        self._offsets = np.array((0.0, *faces.offsets))[surfaces]
        colours = np.vstack((world.floor.colour, faces.colours))[surfaces]
        self._shades = shade_in_steps(colours, self._normals @ np.array(world.light.direction), world.light)
        self._axes = TILE_PX * np.array([wrap.axes for wrap in wraps]).reshape(-1, 2, 3)
        self._shifts = TILE_PX * np.array([wrap.shift for wrap in wraps]).reshape(-1, 2)
        self._scales = np.array([wrap.texture.scale_m for wrap in wraps])
        tiles = {wrap.texture: wrap.texture.tile.reshape(-1).astype(np.float32) for wrap in wraps}
        self._tiles = [tiles[wrap.texture] for wrap in wraps]
        self._means = [tile.mean() for tile in self._tiles]

    @property
    def is_needed(self) -> bool:
        return any(self.numbers)

    def paint(self, canvas: PixelBuffer, numbers: PixelBuffer, view: CameraView, facets: Iterable[Facet]) -> None:
        """Paint the patterns of the ground and of these facets.

        numbers: for each pixel of the canvas the number of the surface that it shows, or 0 for no pattern.
        """
        maps, sharpness = self._project(view)
        for number, window in self._iterate_windows(facets, canvas.shape):
            is_shown = numbers[window] == number
            if np.count_nonzero(is_shown):
                at = number - 1
                levels = _compute_brightness(maps[at], sharpness[at], self._tiles[at], self._means[at], window)
                np.copyto(canvas[window], self._shades[at].take(levels), where=is_shown)

    def _iterate_windows(self, facets: Iterable[Facet], size: tuple[int, ...]) -> Iterator[tuple[int, Window]]:
        """Yield a surface's number and a window, for all windows in which the surface may be visible."""
        height, width = size
        ground, *faces = self.numbers
        boxes = [(ground, (0.0, 0.0, width, height)), *((faces[facet.face], facet.area.box) for facet in facets)]
        for number, (left, top, right, bottom) in boxes:
            columns = slice(max(math.ceil(left), 0), min(math.floor(right) + 1, width))
            rows = range(max(math.ceil(top), 0), min(math.floor(bottom) + 1, height))
            if number and columns.stop > columns.start:
                step = max(WINDOW_PX // (columns.stop - columns.start), 1)
                for first in rows[::step]:
                    yield number, (slice(first, min(first + step, rows.stop)), columns)

    def _project(self, view: CameraView) -> tuple[Singles, Singles]:
        """Return for each surface the map from pixels (u, v) to texels, (n, 3, 3), and the sharpness, (n,).

        A ray e + t·d meets the plane n·p = o at t = k / n·d with k = o - n·e. The texel at this point p is
        a·p + s = ((a·e + s) n·d + k a·d) / n·d. Numerator and denominator are linear in u and v.

        From one pixel to the next, the point moves on the surface by up to k f / (n·d)², with the focal length f.
        So the width of a tile in the picture is proportional to (n·d)². The sharpness is the factor, in units of
        `FADING_PX`.
        """
        i = view.intrinsics
        from_pixel = np.array(((1, 0, -i.cx), (0, 1, -i.cy), (0, 0, i.focal_length)))
        slopes = (self._normals @ view.rotation.T @ from_pixel)[:, None]
        gaps = self._offsets - self._normals @ view.eye
        places = self._axes @ view.eye + self._shifts
        ways = places[..., None] * slopes + gaps[:, None, None] * (self._axes @ view.rotation.T @ from_pixel)
        pixels = self._scales / np.maximum(-gaps, 1e-9) / i.focal_length
        return np.concatenate((ways, slopes), axis=1).astype(np.float32), (pixels / FADING_PX).astype(np.float32)


def _compute_brightness(
    maps: Singles, sharpness: np.float32, tile: Singles, mean: np.float32, window: Window
) -> NDArray[np.int32]:
    """Return the brightness of the pattern at each pixel of a window, from 0 to 255.

    mean: the mean of the tile.
    """
    rows, columns = window
    along, up, slope = (_evaluate(each, NUMBERS[columns], NUMBERS[rows, None]) for each in maps)
    slope = np.minimum(slope, EDGE_ON)
    column, row = (_wrap(way / slope) for way in (along, up))
    levels = tile.take(row * TILE_PX + column)
    contrast = np.minimum(np.maximum(slope * slope * sharpness - VANISHED_PX / FADING_PX, 0.0), 1.0)
    levels -= mean
    levels *= contrast
    levels += mean
    return levels.astype(np.int32)


def _evaluate(coefficients: Singles, u: Singles, v: Singles) -> Singles:
    """Return a·u + b·v + c, (rows, columns), or (rows, 1) or (1, columns) if it depends on one of both only.

    coefficients: a, b and c, (3,).
    u, v: the columns, (columns,), and the rows, (rows, 1).
    """
    a, b, c = coefficients
    if not a:
        return np.asarray(b * v + c)
    return np.asarray(a * u + (b * v + c if b else c))


def _wrap(texels: Singles) -> NDArray[np.int32]:
    """Return the rows or the columns of texels in a tile, for those of a pattern that repeats the tile."""
    np.floor(texels, out=texels)
    # A greater single is a multiple of the width of a tile too, but not every integer can hold it.
    np.minimum(np.maximum(texels, -MAX_TEXEL, out=texels), MAX_TEXEL, out=texels)
    return texels.astype(np.int32) & (TILE_PX - 1)
