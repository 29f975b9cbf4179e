"""Rays over a grid, all at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.autonomy.navigation.paths import Mask

Angles = NDArray[np.float64]
Cells = NDArray[np.intp]


class Rays(NamedTuple):
    """The cells that rays pass: arrays of shape (starts, angles, radii).

    Where a ray has left the grid it is not ``inside``; its rows and columns stay at the border there.
    """

    rows: Cells
    columns: Cells
    inside: Mask

    def of(self, mask: Mask) -> Mask:
        """Return what a mask of the grid says along the rays; False outside."""
        return np.asarray(mask[self.rows, self.columns] & self.inside)


def rays_from(starts: Cells, angles: Angles, radii: Cells, count: int) -> Rays:
    """Return the rays from cells, (n, 2), at angles in radians, at radii in cells, over a grid of count × count."""
    rows = starts[:, 0, None, None] + np.rint(np.sin(angles)[:, None] * radii).astype(np.intp)
    columns = starts[:, 1, None, None] + np.rint(np.cos(angles)[:, None] * radii).astype(np.intp)
    inside = (rows >= 0) & (rows < count) & (columns >= 0) & (columns < count)
    return Rays(rows.clip(0, count - 1), columns.clip(0, count - 1), inside)


def hidden(hides: Mask) -> Mask:
    """Return which cells of rays, (…, radii), are hidden: from the first that hides on."""
    return np.asarray(np.logical_or.accumulate(hides, axis=-1))
