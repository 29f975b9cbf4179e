"""Finds the order in which bodies must be painted, so that near bodies cover far ones.

An order by distance is wrong for long bodies. So each pair of bodies is compared: if an upright plane separates them,
the body on the camera's side of the plane is painted later. A topological sort combines these comparisons.
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
    """The upright planes that separate the painted parts: the blocks and the balls.

    Each plane touches one part, which lies behind the plane. ``_behind``, (planes, parts), is True for this part.
    ``_before``, (planes, parts), is True for each part that lies completely in front of the plane.

    outlines: the outlines of the blocks.
    discs: the outlines of the balls, (n, 3): x, y and radius.
    """

    def __init__(self, outlines: Sequence[Outline], discs: Array) -> None:
        planes = (_along_prisms(outlines, discs), _around_discs(outlines, discs))
        normals, offsets, behind, before = (np.concatenate(both) for both in zip(*planes, strict=True))
        self._normals, self._offsets, self._behind, self._before = normals, offsets, behind, before

    def hidden_by(self, eye: Array) -> Matrix:
        """Return a matrix that is True at [a, b] if part b may hide part a, but a cannot hide b.

        eye: the camera's position. Only x and y count.
        """
        is_before = self._normals @ eye[:2] > self._offsets
        nearer = self._behind.T @ (self._before & is_before[:, None])
        farther = self._behind.T @ (self._before & ~is_before[:, None])
        may_hide: Matrix = nearer | farther.T
        return may_hide & ~may_hide.T


def back_to_front(hidden_by: Matrix) -> list[int]:
    """Return the numbers of the parts in an order in which each part comes after the parts that it hides.

    If the camera is level, upright bodies never hide one another in a cycle. If the camera is tilted, there may be a
    cycle. It is broken at the part that hides the fewest parts that are not yet in the order.
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
    """Return a matrix that is True at [a, b] if the bodies a and b share no column of the picture.

    columns: for each body, the first and the last column of each of its parts.
    """
    begins = np.array([min(begin for begin, _ in parts) for parts in columns])
    ends = np.array([max(end for _, end in parts) for parts in columns])
    is_left: Matrix = ends[:, None] < begins
    return is_left | is_left.T


Planes = tuple[Array, Array, Matrix, Matrix]


def _along_prisms(outlines: Sequence[Outline], discs: Array) -> Planes:
    """Return the planes of the sides of all outlines: normals, offsets, and the parts behind and before each plane."""
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
    """Return for each disc and each other part the plane that touches the disc at the point nearest to the part."""
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
