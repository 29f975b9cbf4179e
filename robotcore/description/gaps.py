"""Gaps between outlines on the floor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotcore.description.world import Floor, Outline

Array = NDArray[np.float64]


def gap_between(one: Outline, other: Outline) -> float:
    """Return how far apart two convex outlines are, in metres.

    Below zero where they overlap; never more than the true distance. By separating axes: Ericson, Real-Time
    Collision Detection, 5.2.1.
    """
    a, b = np.array(one), np.array(other)
    return max(_beyond_sides(a, b), _beyond_sides(b, a))


def gap_to_edge(outline: Outline, floor: Floor) -> float:
    """Return how far inside the floor's edge an outline lies, in metres; below zero where it stands out."""
    half = np.array((floor.length_m, floor.width_m)) / 2
    return float((half - np.abs(np.array(outline))).min())


def _beyond_sides(outline: Array, corners: Array) -> float:
    """Return how far all the corners lie beyond that side of a counter-clockwise outline which they lie beyond most."""
    sides = np.roll(outline, -1, axis=0) - outline
    normals = np.stack((sides[:, 1], -sides[:, 0]), axis=1) / np.hypot(sides[:, :1], sides[:, 1:])
    offsets = (normals * outline).sum(axis=1)
    return float(((normals @ corners.T).min(axis=1) - offsets).max())
