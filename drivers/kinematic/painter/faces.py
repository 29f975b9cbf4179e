"""The faces of a world's prisms, and how they appear in a picture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotcore.description import WorldDescription
from robotcore.description.world import Prism
from robotcore.projection import View

from drivers.kinematic.painter.shading import Inks, inks_of

Array = NDArray[np.float64]
Polygon = list[list[float]]

NEAR_M = 1e-9
"""Nothing nearer than this is seen. Nearer than any robot comes, so that a wall it touches hides the rest."""

BEHIND, LEFT, RIGHT, ABOVE, BELOW = (1 << bit for bit in range(5))


@dataclass(frozen=True)
class Facet:
    """A face in the picture: its corners in pixels, clockwise; ``face`` numbers it, ``thing`` its prism."""

    polygon: Polygon
    face: int
    thing: int


class Faces:
    """All sides and tops of prisms. ``owners``, (n,), number the prism of each face; ``inks``, (n,), colour it."""

    def __init__(self, world: WorldDescription) -> None:
        loops: list[Array] = []
        owners: list[int] = []
        for number, prism in enumerate(world.prisms):
            faces = list(_faces_of(prism))
            loops += faces
            owners += [number] * len(faces)
        self.owners = np.array(owners, dtype=np.intp)
        self._corners = np.concatenate(loops) if loops else np.empty((0, 3))
        self._ends = np.cumsum([len(loop) for loop in loops], dtype=np.intp)
        self._starts = self._ends - [len(loop) for loop in loops]
        self.normals = np.array([_normal(loop) for loop in loops]).reshape(-1, 3)
        self.offsets = np.array([_normal(loop) @ loop[0] for loop in loops])
        colours = np.array([prism.colour for prism in world.prisms], dtype=np.float64).reshape(-1, 3)
        cosines = self.normals @ np.array(world.light.direction)
        self.inks: Inks = inks_of(colours[self.owners], cosines, world.light)

    def facets(self, view: View) -> Iterator[Facet]:
        """Yield the faces that are turned to the eye and not wholly outside the picture."""
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


def _faces_of(prism: Prism) -> Iterator[Array]:
    """Yield the corners of each face, (n, 3), clockwise as seen from outside."""
    outline = prism.outline
    height = prism.height_m
    for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True):
        yield np.array(((ax, ay, height), (bx, by, height), (bx, by, 0.0), (ax, ay, 0.0)))
    yield np.array([(x, y, height) for x, y in reversed(outline)])


def _normal(loop: Array) -> Array:
    normal = np.cross(loop[2] - loop[1], loop[1] - loop[0])
    return np.asarray(normal / np.linalg.norm(normal))


def _sides_outside(view: View, corners: Array) -> NDArray[np.uint8]:
    """Return for each corner in camera coordinates, (n, 3), which planes of the picture it is beyond, as bits."""
    i = view.intrinsics
    right, down, forward = corners.T
    half_width = i.width / 2 / i.focal_length * forward
    half_height = i.height / 2 / i.focal_length * forward
    beyond = (forward <= NEAR_M, right < -half_width, right > half_width, down < -half_height, down > half_height)
    bits = zip((BEHIND, LEFT, RIGHT, ABOVE, BELOW), beyond, strict=True)
    return np.asarray(sum(bit * outside.astype(np.uint8) for bit, outside in bits), dtype=np.uint8)


def _cut(view: View, corners: Array) -> Polygon:
    """Return in pixels what of a face in camera coordinates, (n, 3), lies ahead of the near plane.

    Sutherland and Hodgman, Reentrant Polygon Clipping, 1974.
    """
    ahead: list[Array] = []
    for here, there in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if here[2] >= NEAR_M:
            ahead.append(here)
        if (here[2] >= NEAR_M) != (there[2] >= NEAR_M):
            crossing = here + (there - here) * ((NEAR_M - here[2]) / (there[2] - here[2]))
            ahead.append(np.array((crossing[0], crossing[1], NEAR_M)))
    polygon: Polygon = view.to_pixels(np.array(ahead)).tolist()
    return polygon
