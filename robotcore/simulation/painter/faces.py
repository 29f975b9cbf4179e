"""Split the prisms of a world into blocks that do not overlap, and project the faces of the blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robotcore.description import Light
from robotcore.description.generation.gaps import compute_gap
from robotcore.description.world import Outline, WorldDescription
from robotcore.optics import CameraView
from robotcore.raycast import edges_of
from robotcore.simulation.painter.canvas import PackedColours, Palette, PixelBuffer, shade
from robotcore.simulation.painter.planes import Array, compute_half_planes
from robotcore.simulation.painter.projection import Point, PolygonSet, clip
from robotcore.simulation.painter.rasterizing import Area

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


def _subtract(outline: Outline, hole: Outline) -> Iterator[Outline]:
    """Yield convex outlines that together cover the area of ``outline`` outside ``hole``."""
    if compute_gap(outline, hole) > -TOUCHING_M:
        yield outline
        return
    rest: list[Point] = list(outline)
    for normal, offset in zip(*compute_half_planes(edges_of([hole])), strict=True):
        past = np.round(np.array(rest) @ normal - offset, 9)
        if (past > 0).any():
            yield tuple((float(x), float(y)) for x, y in clip(rest, past.tolist()))
            rest = clip(rest, (-past).tolist())


class Facet(NamedTuple):
    """A face as the camera sees it."""

    area: Area
    face: int
    """The number of the face in `Faces`."""
    part: int
    """The number of its block."""

    @property
    def columns(self) -> tuple[float, float]:
        left, _, right, _ = self.area.box
        return left, right

    def paint(self, canvas: PixelBuffer, palette: Palette) -> None:
        self.area.fill(canvas, palette.faces[self.face])


class Faces:
    """The sides and tops of all blocks, as n faces.

    ``block_numbers``, (n,), holds for each face the number of its block. ``normals``, (n, 3), and ``offsets``, (n,),
    are the planes of the faces: a point p lies in the plane if ``normal @ p == offset``.
    """

    def __init__(self, blocks: Sequence[Block]) -> None:
        faces = [(number, corners) for number, block in enumerate(blocks) for corners in _list_corners(block)]
        loops = [corners for _, corners in faces]
        self.block_numbers = np.array([number for number, _ in faces], dtype=np.intp)
        self._parts = self.block_numbers.tolist()
        self._colours = np.array([block.colour for block in blocks], dtype=np.float64).reshape(-1, 3)
        self._polygons = PolygonSet(loops)
        normals = [_compute_normal(loop) for loop in loops]
        self.normals = np.array(normals).reshape(-1, 3)
        self.offsets = np.array([normal @ loop[0] for normal, loop in zip(normals, loops, strict=True)])

    @property
    def colours(self) -> Array:
        """Red, green and blue of each face, (n, 3)."""
        return np.asarray(self._colours[self.block_numbers])

    def shade(self, light: Light) -> PackedColours:
        """Return the colour of each face under a light, (n,)."""
        return shade(self.colours, self.normals @ np.array(light.direction), light)

    def facets(self, view: CameraView) -> Iterator[Facet]:
        """Yield each face that points to the camera, unless the whole face is outside the picture."""
        is_turned = self.normals @ view.eye > self.offsets
        for face, area in self._polygons.project(view, is_turned):
            yield Facet(area, face, self._parts[face])


def _list_corners(block: Block) -> Iterator[Array]:
    """Yield the corners of each face, (n, 3). They are clockwise for a viewer outside the block."""
    outline, height = block.outline, block.height
    for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True):
        yield np.array(((ax, ay, height), (bx, by, height), (bx, by, 0.0), (ax, ay, 0.0)))
    yield np.array([(x, y, height) for x, y in reversed(outline)])


def _compute_normal(loop: Array) -> Array:
    # Newell's method
    here = loop - loop[0]
    (x, y, z), (next_x, next_y, next_z) = here.T, np.concatenate((here[1:], here[:1])).T
    # `np.cross` takes five times as long for so few corners
    products = np.array((next_y * z - next_z * y, next_z * x - next_x * z, next_x * y - next_y * x)).T
    normal = products.sum(axis=0)
    return np.asarray(normal / np.linalg.norm(normal))
