"""Convex outlines as half-planes, in NumPy."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def half_planes(edges: Array) -> tuple[Array, Array]:
    """Return outward normals, (n, 2), and offsets, (n,), of the edges of counter-clockwise outlines.

    A point p lies outside an edge if normal·p > offset. ``edges`` is the result of `robotcore.raycast.edges_of`.
    """
    normals = np.stack((edges[:, 3], -edges[:, 2]), axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, (normals * edges[:, :2]).sum(axis=1)


def nearest_on(edges: Array, points: Array) -> Array:
    """Return for each point, (n, 2), the nearest point on each edge, (n, m, 2)."""
    starts, ways = edges[:, :2], edges[:, 2:]
    lengths = np.maximum((ways * ways).sum(axis=1), np.finfo(np.float64).tiny)
    along = ((points[:, None] - starts) * ways).sum(axis=2) / lengths
    return np.asarray(starts + np.clip(along, 0.0, 1.0)[..., None] * ways)


def run_starts(lengths: Iterable[int]) -> NDArray[np.intp]:
    """Return the start index of each run in an array of successive runs with these lengths.

    ``numpy.ufunc.reduceat`` needs these indices.
    """
    return np.cumsum([0, *lengths], dtype=np.intp)[:-1]
