"""The hues that some colours leave free."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

Arc = tuple[float, float]
"""Where a range of hues starts on the colour circle, and its length, in degrees."""


def free_arcs(taken: Iterable[float], gap: float) -> list[Arc]:
    """Return the ranges of hues that are more than ``gap`` degrees away from each that is taken."""
    hues = sorted(hue % 360 for hue in taken)
    if not hues:
        return [(0.0, 360.0)]
    neighbours = pairwise([*hues, hues[0] + 360])
    return [(low + gap, high - low - 2 * gap) for low, high in neighbours if high - low > 2 * gap]


def hue_at(arcs: Sequence[Arc], share: float) -> float:
    """Return the hue at a share, 0 to 1, of the way through all the arcs; it may lie beyond 360."""
    along = share * sum(length for _, length in arcs)
    for start, length in arcs:
        if along <= length:
            return start + along
        along -= length
    start, length = arcs[-1]
    return start + length
