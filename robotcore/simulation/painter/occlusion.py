"""Find the order in which bodies must be painted, so that near bodies cover far ones.

An order by distance is wrong for long bodies. So this module compares each pair of bodies. If an upright plane
separates two bodies, the body on the camera's side is painted later. A topological sort combines these comparisons.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from robotcore.raycast import Outline, edges_of
from robotcore.simulation.painter.faces import TOUCHING_M
from robotcore.simulation.painter.planes import Array, compute_half_planes, compute_run_starts, find_nearest_points

Matrix = NDArray[np.bool_]


class OcclusionPlanes:
    """Upright planes that separate the parts of a world. A part is a block or a ball.

    Each plane touches one part, which lies behind the plane. ``_behind``, (planes, parts), is True for this part.
    ``_before``, (planes, parts), is True for each part that lies completely in front of the plane.

    outlines: the outlines of the blocks.
    discs: the outlines of the balls, (n, 3): x, y and radius.
    """

    def __init__(self, outlines: Sequence[Outline], discs: Array) -> None:
        planes = (_compute_side_planes(outlines, discs), _compute_tangent_planes(outlines, discs))
        self._normals, self._offsets, behind, self._before = (
            np.concatenate(both) for both in zip(*planes, strict=True)
        )
        self._behind = behind.T.astype(np.float32)  # NumPy multiplies matrices of truth values slowly
        self._latest: tuple[bytes, list[list[bool]]] | None = None

    def sort_back_to_front(self, eye: Array, columns: Mapping[int, tuple[float, float]]) -> list[int]:
        """Return the numbers of parts, sorted so that each part comes after the parts that it hides.

        eye: the camera's position. Its height has no effect.
        columns: for each part, by its number, the first and the last column of the picture that it may cover.
        """
        hiders = self._find_hiders(eye)
        spans = columns.items()
        return sort_back_to_front(
            {
                part: [
                    other
                    for other, (begin, end) in spans
                    if hiders[part][other] and begin <= last and first <= end  # other columns hide nothing
                ]
                for part, (first, last) in spans
            }
        )

    def _find_hiders(self, eye: Array) -> list[list[bool]]:
        """Return a matrix, (parts, parts). It is True at [a][b] if part b may hide part a, and a cannot hide b."""
        is_before = self._normals @ eye[:2] > self._offsets
        sides = is_before.tobytes()
        if not self._latest or self._latest[0] != sides:  # from picture to picture, the eye seldom passes a plane
            nearer = self._behind @ (self._before & is_before[:, None]) > 0
            farther = self._behind @ (self._before & ~is_before[:, None]) > 0
            may_hide = nearer | farther.T
            self._latest = sides, (may_hide & ~may_hide.T).tolist()
        return self._latest[1]


def sort_back_to_front(hiders: Mapping[int, Sequence[int]]) -> list[int]:
    """Return the numbers of the parts, sorted so that each part comes after the parts that it hides.

    If the camera is tilted, some parts may hide one another in a cycle. Then the next part is the one that hides the
    fewest of the parts that are not yet in the order.

    hiders: for each part the parts that may hide it.
    """
    waits_for = dict.fromkeys(hiders, 0)
    for others in hiders.values():
        for other in others:
            waits_for[other] += 1
    order: list[int] = []
    while waits_for:
        chosen = min(waits_for, key=waits_for.__getitem__)
        del waits_for[chosen]
        order.append(chosen)
        for other in hiders[chosen]:
            if other in waits_for:
                waits_for[other] -= 1
    return order


_Planes = tuple[Array, Array, Matrix, Matrix]
"""Normals, offsets, and the matrices of the parts behind and of the parts in front of each plane."""


def _compute_side_planes(outlines: Sequence[Outline], discs: Array) -> _Planes:
    normals, offsets = compute_half_planes(edges_of(outlines))
    corners = np.array([corner for outline in outlines for corner in outline]).reshape(-1, 2)
    past = corners @ normals.T - offsets
    starts = compute_run_starts(map(len, outlines))
    prisms_past = np.minimum.reduceat(past, starts, axis=0) if len(starts) else past
    discs_past = discs[:, :2] @ normals.T - offsets - discs[:, 2:]
    before = np.concatenate((prisms_past, discs_past)).T >= -TOUCHING_M
    block_numbers = np.repeat(np.arange(len(outlines)), [len(outline) for outline in outlines])
    return normals, offsets, block_numbers[:, None] == np.arange(before.shape[1]), before


def _compute_tangent_planes(outlines: Sequence[Outline], discs: Array) -> _Planes:
    """Return for each disc and each other part a plane. It touches the disc at the point nearest to that part."""
    shapes: list[Array] = [edges_of([outline]) for outline in outlines]
    shapes += [np.array(((x, y, 0.0, 0.0),)) for x, y, _ in discs]
    numbers = range(len(outlines), len(shapes))
    pairs = [(disc, other) for disc in numbers for other in range(len(shapes)) if disc != other]
    planes = [_compute_tangent(discs[disc - len(outlines)], shapes[other]) for disc, other in pairs]
    ends = np.array(pairs, dtype=np.intp).reshape(-1, 2)
    behind, before = (ends[:, column, None] == np.arange(len(shapes)) for column in (0, 1))
    return np.array([n for n, _ in planes]).reshape(-1, 2), np.array([o for _, o in planes]), behind, before


def _compute_tangent(disc: Array, edges: Array) -> tuple[Array, float]:
    """Return the normal and the offset of the plane that touches a disc on the side of the nearest edge."""
    centre, radius = disc[:2], float(disc[2])
    ways = find_nearest_points(edges, centre[None])[0] - centre
    way = ways[np.linalg.norm(ways, axis=1).argmin()]
    normal = way / max(float(np.linalg.norm(way)), TOUCHING_M)
    return normal, float(normal @ centre) + radius
