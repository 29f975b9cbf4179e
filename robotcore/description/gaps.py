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
    """Return how far all the corners lie beyond a counter-clockwise outline, by the best of its sides."""
    dx, dy = (np.concatenate((outline[1:], outline[:1])) - outline).T
    normals = np.array((dy, -dx)) / np.hypot(dx, dy)
    offsets = (outline.T * normals).sum(axis=0)
    return float(((corners @ normals).min(axis=0) - offsets).max())
