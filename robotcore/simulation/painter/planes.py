"""Convex outlines as half-planes, in NumPy."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def compute_half_planes(edges: Array) -> tuple[Array, Array]:
    """Return the outward normals, (n, 2), and the offsets, (n,), of the edges of counter-clockwise outlines.

    edges: the result of `robotcore.raycast.edges_of`.

    A point p lies outside an edge if normal·p > offset.
    """
    normals = np.stack((edges[:, 3], -edges[:, 2]), axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, (normals * edges[:, :2]).sum(axis=1)


def find_nearest_points(edges: Array, points: Array) -> Array:
    """Return for each of n points, (n, 2), the nearest point on each of m edges, (n, m, 2)."""
    starts, ways = edges[:, :2], edges[:, 2:]
    lengths = np.maximum((ways * ways).sum(axis=1), np.finfo(np.float64).tiny)
    along = ((points[:, None] - starts) * ways).sum(axis=2) / lengths
    return np.asarray(starts + np.clip(along, 0.0, 1.0)[..., None] * ways)


def compute_run_starts(lengths: Iterable[int]) -> NDArray[np.intp]:
    """Return the start index of each run in an array of successive runs, for ``numpy.ufunc.reduceat``.

    lengths: the length of each run.

    >>> compute_run_starts([3, 1, 2]).tolist()
    [0, 3, 4]
    """
    return np.cumsum([0, *lengths], dtype=np.intp)[:-1]
