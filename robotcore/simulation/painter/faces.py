"""Split the prisms of a world into blocks that do not overlap, and project the faces of the blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Light
from robotcore.description.generation.clearance import gap_between
from robotcore.description.world import Outline, WorldDescription
from robotcore.optics import CameraView
from robotcore.raycast import edges_of
from robotcore.simulation.painter.canvas import Canvas, PackedColours, Palette, fill, shade
from robotcore.simulation.painter.planes import Array, compute_half_planes, compute_run_starts

TOUCHING_M = 1e-9
"""Two bodies that overlap by less than this length, in metres, count as bodies that only touch."""


@dataclass(frozen=True)
class Block:
    """A convex part of a prism. ``prism_index`` is the index of the prism in the world's prisms."""

    outline: Outline
    height: float
    colour: tuple[int, int, int]
    prism_index: int


def split_into_blocks(world: WorldDescription) -> list[Block]:
    """Return the blocks of the world's prisms. If prisms overlap, the overlap belongs to the tallest of them."""
    blocks: list[Block] = []
    tallest_first = sorted(enumerate(world.prisms), key=lambda entry: -entry[1].height_m)
    for index, prism in tallest_first:
        rest: list[Outline] = [prism.outline]
        for taller in blocks:
            rest = [part for outline in rest for part in _subtract(outline, taller.outline)]
        blocks += [Block(outline, prism.height_m, prism.colour, index) for outline in rest]
    return blocks


def clip(polygon: Sequence[Array], depths: Sequence[float]) -> list[Array]:
    """Clip a convex polygon at depth 0, and return the corners of the part with a depth of 0 or more.

    depths: the depth at each corner of the polygon.

    Source: Sutherland and Hodgman, Reentrant Polygon Clipping, 1974.
    """
    kept: list[Array] = []
    for i, (here, depth) in enumerate(zip(polygon, depths, strict=True)):
        before = depths[i - 1]
        if before * depth < 0:
            kept.append(polygon[i - 1] + (here - polygon[i - 1]) * (before / (before - depth)))
        if depth >= 0:
            kept.append(here)
    return kept


def _subtract(outline: Outline, hole: Outline) -> Iterator[Outline]:
    """Yield convex outlines that together cover the area of ``outline`` outside ``hole``."""
    if gap_between(outline, hole) > -TOUCHING_M:
        yield outline
        return
    rest = list(np.array(outline))
    for normal, offset in zip(*compute_half_planes(edges_of([hole])), strict=True):
        past = np.round(np.array(rest) @ normal - offset, 9)
        if (past > 0).any():
            yield tuple((float(x), float(y)) for x, y in clip(rest, past.tolist()))
            rest = clip(rest, (-past).tolist())


Polygon = list[list[float]]

NEAR_M = 1e-9
"""The distance of the near clipping plane from the camera, in metres.

It is so small that a camera sees a wall even while its robot touches the wall.
"""

_BEHIND, _LEFT, _RIGHT, _ABOVE, _BELOW = (1 << bit for bit in range(5))


@dataclass(frozen=True)
class Facet:
    """A face as the camera sees it.

    ``polygon`` holds the corners in pixels, clockwise. ``face`` is the number of the face in `Faces`. ``part`` is the
    number of its block.
    """

    polygon: Polygon
    face: int
    part: int

    @property
    def columns(self) -> tuple[float, float]:
        across = [u for u, _ in self.polygon]
        return min(across), max(across)

    @property
    def box(self) -> tuple[float, float, float, float]:
        """The left, top, right and bottom edge of the face's bounding box, in pixels."""
        (left, right), down = self.columns, [v for _, v in self.polygon]
        return left, min(down), right, max(down)

    def paint(self, canvas: Canvas, palette: Palette) -> None:
        fill(canvas, self.polygon, palette.faces[self.face])


class Faces:
    """The sides and tops of all blocks, as n faces.

    ``block_numbers``, (n,), holds for each face the number of its block. ``normals``, (n, 3), and ``offsets``, (n,),
    are the planes of the faces: a point p lies in the plane if ``normal @ p == offset``.
    """

    def __init__(self, blocks: Sequence[Block]) -> None:
        faces = [(number, corners) for number, block in enumerate(blocks) for corners in _list_corners(block)]
        loops = [corners for _, corners in faces]
        self.block_numbers = np.array([number for number, _ in faces], dtype=np.intp)
        self._colours = np.array([block.colour for block in blocks], dtype=np.float64).reshape(-1, 3)
        self._corners = np.concatenate((np.empty((0, 3)), *loops))
        self._starts = compute_run_starts(map(len, loops))
        self._ends = self._starts + np.array([len(loop) for loop in loops], dtype=np.intp)
        self.normals = np.array([_normal(loop) for loop in loops]).reshape(-1, 3)
        self.offsets = np.array([_normal(loop) @ loop[0] for loop in loops])

    @property
    def colours(self) -> Array:
        """Red, green and blue of each face, (n, 3)."""
        return np.asarray(self._colours[self.block_numbers])

    def shade(self, light: Light) -> PackedColours:
        """Return the colour of each face under a light, (n,)."""
        return shade(self.colours, self.normals @ np.array(light.direction), light)

    def facets(self, view: CameraView) -> Iterator[Facet]:
        """Yield each face that points to the camera, unless the whole face is outside the picture."""
        if not len(self.block_numbers):
            return
        corners = view.to_camera(self._corners)
        pixels = view.to_pixels(np.maximum(corners, (-np.inf, -np.inf, NEAR_M)))
        sides = _compute_side_bits(view, corners)
        is_turned = self.normals @ view.eye > self.offsets
        is_outside = np.bitwise_and.reduceat(sides, self._starts) != 0
        is_cut = (np.bitwise_or.reduceat(sides, self._starts) & _BEHIND) != 0
        for face in np.flatnonzero(is_turned & ~is_outside).tolist():
            span = slice(self._starts[face], self._ends[face])
            polygon = _clip_at_near_plane(view, corners[span]) if is_cut[face] else pixels[span].tolist()
            yield Facet(polygon, face, int(self.block_numbers[face]))


def _list_corners(block: Block) -> Iterator[Array]:
    """Yield the corners of each face, (n, 3). They are clockwise for a viewer outside the block."""
    outline, height = block.outline, block.height
    for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True):
        yield np.array(((ax, ay, height), (bx, by, height), (bx, by, 0.0), (ax, ay, 0.0)))
    yield np.array([(x, y, height) for x, y in reversed(outline)])


def _normal(loop: Array) -> Array:
    # Newell's method
    normal = np.cross(np.roll(loop, -1, axis=0) - loop[0], loop - loop[0]).sum(axis=0)
    return np.asarray(normal / np.linalg.norm(normal))


def _compute_side_bits(view: CameraView, corners: Array) -> NDArray[np.uint8]:
    """Return a bit set for each corner. A bit is set if the corner is beyond that side of the picture.

    corners: points in the camera's frame, (n, 3).
    """
    i = view.intrinsics
    right, down, forward = corners.T
    half_width = i.width / 2 / i.focal_length * forward
    half_height = i.height / 2 / i.focal_length * forward
    bits = (forward < NEAR_M) * _BEHIND
    bits |= (right < -half_width) * _LEFT
    bits |= (right > half_width) * _RIGHT
    bits |= (down < -half_height) * _ABOVE
    bits |= (down > half_height) * _BELOW
    return np.asarray(bits, dtype=np.uint8)


def _clip_at_near_plane(view: CameraView, corners: Array) -> Polygon:
    """Clip a face at the near plane, and return the corners of the rest in pixels.

    corners: the face's corners in the camera's frame, (n, 3).
    """
    ahead = np.array(clip(list(corners), (corners[:, 2] - NEAR_M).tolist()))
    polygon: Polygon = view.to_pixels(ahead).tolist()
    return polygon
