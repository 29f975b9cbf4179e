"""Splits the prisms of a world into blocks that do not overlap, and projects their faces."""

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
from robotcore.simulation.painter.canvas import Canvas, Inks, Palette, fill, shade_inks
from robotcore.simulation.painter.planes import Array, half_planes, run_starts

TOUCHING_M = 1e-9
"""Bodies that overlap by a shorter length count as bodies that only touch."""


@dataclass(frozen=True)
class Block:
    """A convex part of a prism. ``thing`` is the index of the prism in the world's prisms."""

    outline: Outline
    height: float
    colour: tuple[int, int, int]
    thing: int


def split_into_blocks(world: WorldDescription) -> list[Block]:
    """Return the blocks of the world's prisms. The space in which prisms overlap belongs to the tallest of them."""
    blocks: list[Block] = []
    tallest_first = sorted(enumerate(world.prisms), key=lambda entry: -entry[1].height_m)
    for thing, prism in tallest_first:
        rest: list[Outline] = [prism.outline]
        for taller in blocks:
            rest = [part for outline in rest for part in _outside(outline, taller.outline)]
        blocks += [Block(outline, prism.height_m, prism.colour, thing) for outline in rest]
    return blocks


def clip(polygon: Sequence[Array], depths: Sequence[float]) -> list[Array]:
    """Return the corners of the part of a convex polygon in which the depth is 0 or more.

    depths: the depth at each corner of the polygon.

    See Sutherland and Hodgman, Reentrant Polygon Clipping, 1974.
    """
    kept: list[Array] = []
    for i, (here, depth) in enumerate(zip(polygon, depths, strict=True)):
        before = depths[i - 1]
        if before * depth < 0:
            kept.append(polygon[i - 1] + (here - polygon[i - 1]) * (before / (before - depth)))
        if depth >= 0:
            kept.append(here)
    return kept


def _outside(outline: Outline, hole: Outline) -> Iterator[Outline]:
    """Yield convex parts of an outline that together cover its area outside another outline."""
    if gap_between(outline, hole) > -TOUCHING_M:
        yield outline
        return
    rest = list(np.array(outline))
    for normal, offset in zip(*half_planes(edges_of([hole])), strict=True):
        past = np.round(np.array(rest) @ normal - offset, 9)
        if (past > 0).any():
            yield tuple((float(x), float(y)) for x, y in clip(rest, past.tolist()))
            rest = clip(rest, (-past).tolist())


Polygon = list[list[float]]

NEAR_M = 1e-9
"""The distance of the near plane from the camera. A robot's camera is always farther from a wall that it touches."""

BEHIND, LEFT, RIGHT, ABOVE, BELOW = (1 << bit for bit in range(5))


@dataclass(frozen=True)
class Facet:
    """A face in the picture: its corners in pixels, clockwise, its own number and the number of its block."""

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
    """All sides and tops of blocks. ``owners``, (n,), holds the number of each face's block.

    ``normals``, (n, 3), and ``offsets``, (n,), are the planes of the faces: a point p with ``normal @ p == offset``
    lies in the plane of a face.
    """

    def __init__(self, blocks: Sequence[Block]) -> None:
        faces = [(owner, corners) for owner, block in enumerate(blocks) for corners in _faces_of(block)]
        loops = [corners for _, corners in faces]
        self.owners = np.array([owner for owner, _ in faces], dtype=np.intp)
        self._colours = np.array([block.colour for block in blocks], dtype=np.float64).reshape(-1, 3)
        self._corners = np.concatenate((np.empty((0, 3)), *loops))
        self._starts = run_starts(map(len, loops))
        self._ends = self._starts + np.array([len(loop) for loop in loops], dtype=np.intp)
        self.normals = np.array([_normal(loop) for loop in loops]).reshape(-1, 3)
        self.offsets = np.array([_normal(loop) @ loop[0] for loop in loops])

    @property
    def colours(self) -> Array:
        """Red, green and blue of each face, (n, 3)."""
        return np.asarray(self._colours[self.owners])

    def lit(self, light: Light) -> Inks:
        """Return the ink of each face under a light, (n,)."""
        return shade_inks(self.colours, self.normals @ np.array(light.direction), light)

    def facets(self, view: CameraView) -> Iterator[Facet]:
        """Yield the faces that point to the camera and are not completely outside the picture."""
        if not len(self.owners):
            return
        corners = view.to_camera(self._corners)
        pixels = view.to_pixels(np.maximum(corners, (-np.inf, -np.inf, NEAR_M)))
        sides = _sides_outside(view, corners)
        is_turned = self.normals @ view.eye > self.offsets
        is_outside = np.bitwise_and.reduceat(sides, self._starts) != 0
        is_cut = (np.bitwise_or.reduceat(sides, self._starts) & BEHIND) != 0
        for face in np.flatnonzero(is_turned & ~is_outside).tolist():
            span = slice(self._starts[face], self._ends[face])
            polygon = _cut(view, corners[span]) if is_cut[face] else pixels[span].tolist()
            yield Facet(polygon, face, int(self.owners[face]))


def _faces_of(block: Block) -> Iterator[Array]:
    """Yield the corners of each face, (n, 3), clockwise as seen from outside."""
    outline, height = block.outline, block.height
    for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True):
        yield np.array(((ax, ay, height), (bx, by, height), (bx, by, 0.0), (ax, ay, 0.0)))
    yield np.array([(x, y, height) for x, y in reversed(outline)])


def _normal(loop: Array) -> Array:
    """Return the unit normal of a polygon, by Newell's method."""
    normal = np.cross(np.roll(loop, -1, axis=0) - loop[0], loop - loop[0]).sum(axis=0)
    return np.asarray(normal / np.linalg.norm(normal))


def _sides_outside(view: CameraView, corners: Array) -> NDArray[np.uint8]:
    """Return for each corner, (n, 3) in the camera's frame, bits for the sides of the picture beyond which it lies."""
    i = view.intrinsics
    right, down, forward = corners.T
    half_width = i.width / 2 / i.focal_length * forward
    half_height = i.height / 2 / i.focal_length * forward
    bits = (forward < NEAR_M) * BEHIND
    bits |= (right < -half_width) * LEFT
    bits |= (right > half_width) * RIGHT
    bits |= (down < -half_height) * ABOVE
    bits |= (down > half_height) * BELOW
    return np.asarray(bits, dtype=np.uint8)


def _cut(view: CameraView, corners: Array) -> Polygon:
    """Return the corners in pixels of the part of a face that is beyond the near plane.

    corners: the face's corners in the camera's frame, (n, 3).
    """
    ahead = np.array(clip(list(corners), (corners[:, 2] - NEAR_M).tolist()))
    polygon: Polygon = view.to_pixels(ahead).tolist()
    return polygon
