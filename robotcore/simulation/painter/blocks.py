"""The prisms of a world as blocks that do not overlap, so that of any two one can be painted first.

Obstacles may reach into each other and into walls. The taller one keeps its shape; what is left of the other
around it falls into convex blocks, together of the same look.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robotcore.description.generation.clearance import gap_between
from robotcore.description.world import Outline, WorldDescription
from robotcore.raycast import edges_of
from robotcore.simulation.painter.planes import Array, half_planes

TOUCHING_M = 1e-9
"""Things that overlap by less are side by side."""


@dataclass(frozen=True)
class Block:
    """A convex prism on the floor; ``thing`` is the place among the world's prisms of the one it is part of."""

    outline: Outline
    height: float
    colour: tuple[int, int, int]
    thing: int


def blocks_of(world: WorldDescription) -> list[Block]:
    """Return the world's prisms, cut where they overlap."""
    blocks: list[Block] = []
    tallest_first = sorted(enumerate(world.prisms), key=lambda entry: -entry[1].height_m)
    for thing, prism in tallest_first:
        rest: list[Outline] = [prism.outline]
        for taller in blocks:
            rest = [part for outline in rest for part in _outside(outline, taller.outline)]
        blocks += [Block(outline, prism.height_m, prism.colour, thing) for outline in rest]
    return blocks


def clip(polygon: Sequence[Array], depths: Sequence[float]) -> list[Array]:
    """Return the corners of that part of a convex polygon where the depth, given at its corners, is not negative.

    Sutherland and Hodgman, Reentrant Polygon Clipping, 1974.
    """
    kept: list[Array] = []
    for i, (here, depth) in enumerate(zip(polygon, depths, strict=True)):
        before = depths[i - 1]
        if before * depth < 0:
            kept.append(polygon[i - 1] + (here - polygon[i - 1]) * (before / (before - depth)))
        if depth >= 0:
            kept.append(here)
    return kept


def _outside(outline: Outline, hole: Outline) -> Iterator[Outline]:
    """Yield convex parts that make up what of an outline lies outside another."""
    if gap_between(outline, hole) > -TOUCHING_M:
        yield outline
        return
    rest = list(np.array(outline))
    for normal, offset in zip(*half_planes(edges_of([hole])), strict=True):
        past = np.round(np.array(rest) @ normal - offset, 9)
        if (past > 0).any():
            yield tuple((float(x), float(y)) for x, y in clip(rest, past.tolist()))
            rest = clip(rest, (-past).tolist())
