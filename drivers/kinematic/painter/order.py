"""Which thing to paint first, so that what is nearer hides what is farther.

Sorting by distance is wrong where things are long. Here, of two things parted by an upright plane, the one on
the eye's side is painted later; a topological sort makes one order of that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Ball, WorldDescription
from robotcore.raycast import Outline

Array = NDArray[np.float64]
Matrix = NDArray[np.bool_]

TOLERANCE_M = 1e-9
"""Things that share a side are still parted by it."""


class PaintingOrder:
    """Knows the planes that part the things of a world: its prisms, then its targets."""

    def __init__(self, world: WorldDescription) -> None:
        outlines = [prism.outline for prism in world.prisms]
        planes = [plane for number, outline in enumerate(outlines) for plane in _sides(number, outline)]
        self._owns = np.array([])
