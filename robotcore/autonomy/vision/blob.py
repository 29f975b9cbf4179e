"""A patch of one colour in a picture."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Blob:
    """A connected patch: pixels for ``centroid``, ``box`` (left, top, width, height) and ``area``.

    ``bearing`` is the direction of the centroid in radians, positive to the left. ``is_clipped`` says that the patch
    touches the picture's edge: what it belongs to is larger than what is seen.
    """

    centroid: tuple[float, float]
    box: tuple[int, int, int, int]
    area: int
    bearing: float
    is_clipped: bool

    @property
    def radius(self) -> float:
        """Half of the box's longer side, in pixels: a ball's, where it is neither clipped nor covered."""
        return max(self.box[2], self.box[3]) / 2
