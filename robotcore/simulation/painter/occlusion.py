"""Finds the order in which to paint bodies, so that near ones hide far ones.

Sorting by distance is wrong for long bodies. Of two parts with an upright plane between them, the one on the
camera's side is painted later. A topological sort combines all pairs that meet in the picture.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotcore.raycast import Outline, edges_of
from robotcore.simulation.painter.faces import TOUCHING_M
from robotcore.simulation.painter.planes import Array, half_planes, nearest_on, run_starts

Matrix = NDArray[np.bool_]


class OcclusionPlanes:
    """The upright planes that part what is painted: outlines, then discs, (n, 3), of x, y and radius.

    Each plane has one part behind it. ``_behind`` and ``_before``, (planes, parts), tell which one that is, and
    which lie wholly in front.
    """

    def __init__(self, outlines: Sequence[Outline], discs: Array) -> None:
        planes = (_along_prisms(outlines, discs), _around_discs(outlines, discs))
        normals, offsets, behind, before = (np.concatenate(both) for both in zip(*planes, strict=True))
        self._normals, self._offsets, self._behind, self._before = normals, offsets, behind, before

    def hidden_by(self, eye: Array) -> Matrix:
        """Return at [a, b] whether b may hide a and a cannot hide b, from a camera at (x, y, …)."""
        is_before = self._normals @ eye[:2] > self._offsets
        nearer = self._behind.T @ (self._before & is_before[:, None])
        farther = self._behind.T @ (self._before & ~is_before[:, None])
        may_hide: Matrix = nearer | farther.T
        return may_hide & ~may_hide.T


def back_to_front(hidden_by: Matrix) -> list[int]:
    """Return an order in which each part comes after the parts that it hides.

    Upright bodies in a level picture never hide one another in a cycle. A cycle in a steep picture is broken at the
    part with the fewest predecessors.
    """
    waits_for = hidden_by.sum(axis=0)
    order: list[int] = []
    for _ in range(len(waits_for)):
        chosen = int(waits_for.argmin())
        order.append(chosen)
        waits_for -= hidden_by[chosen]
        waits_for[chosen] = 2 * len(waits_for)
    return order


def side_by_side(columns: Sequence[Sequence[tuple[float, float]]]) -> Matrix:
    """Return at [a, b] whether two bodies share no column of the picture, from the columns of their parts."""
    begins = np.array([min(begin for begin, _ in parts) for parts in columns])
    ends = np.array([max(end for _, end in parts) for parts in columns])
    is_left: Matrix = ends[:, None] < begins
    return is_left | is_left.T


Planes = tuple[Array, Array, Matrix, Matrix]


def _along_prisms(outlines: Sequence[Outline], discs: Array) -> Planes:
    """Return the planes of all sides: normals, offsets, and the parts behind and before each plane."""
    normals, offsets = half_planes(edges_of(outlines))
    corners = np.array([corner for outline in outlines for corner in outline]).reshape(-1, 2)
    past = corners @ normals.T - offsets
    starts = run_starts(map(len, outlines))
    prisms_past = np.minimum.reduceat(past, starts, axis=0) if len(starts) else past
    discs_past = discs[:, :2] @ normals.T - offsets - discs[:, 2:]
    before = np.concatenate((prisms_past, discs_past)).T >= -TOUCHING_M
    owners = np.repeat(np.arange(len(outlines)), [len(outline) for outline in outlines])
    return normals, offsets, owners[:, None] == np.arange(before.shape[1]), before


def _around_discs(outlines: Sequence[Outline], discs: Array) -> Planes:
    """Return for each disc and each other body the plane that touches the disc at the point nearest to the body."""
    shapes: list[Array] = [edges_of([outline]) for outline in outlines]
    shapes += [np.array(((x, y, 0.0, 0.0),)) for x, y, _ in discs]
    numbers = range(len(outlines), len(shapes))
    pairs = [(disc, other) for disc in numbers for other in range(len(shapes)) if disc != other]
    planes = [_touching(discs[disc - len(outlines)], shapes[other]) for disc, other in pairs]
    ends = np.array(pairs, dtype=np.intp).reshape(-1, 2)
    behind, before = (ends[:, column, None] == np.arange(len(shapes)) for column in (0, 1))
    return np.array([n for n, _ in planes]).reshape(-1, 2), np.array([o for _, o in planes]), behind, before


def _touching(disc: Array, edges: Array) -> tuple[Array, float]:
    """Return the normal and the offset of the plane that touches a disc on the side of the nearest edge."""
    centre, radius = disc[:2], float(disc[2])
    ways = nearest_on(edges, centre[None])[0] - centre
    way = ways[np.linalg.norm(ways, axis=1).argmin()]
    normal = way / max(float(np.linalg.norm(way)), TOUCHING_M)
    return normal, float(normal @ centre) + radius
