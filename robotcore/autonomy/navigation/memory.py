"""What a robot remembers of a place, and how it forgets it."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from robotcore.autonomy.navigation.coverage import Coverage
from robotcore.autonomy.navigation.grid import OccupancyGrid
from robotcore.geometry import Pose, wrap_angle

LATELY = 3.0
"""How much the robot may have moved since, in radians turned and metres driven: odometry still holds as far."""


Remembered = tuple[NDArray[Any], ...]
"""Copies of all that was remembered at some time."""


class Memory:
    """A map, and what was looked at on it."""

    def __init__(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        self.grid, self.coverage = grid, coverage
        self._at: Pose | None = None

    def move(self, pose: Pose) -> None:
        """Take in that the robot has moved on to a pose: what was learnt before grows older by it."""
        if self._at:
            turned = abs(wrap_angle(pose.heading - self._at.heading))
            self.grid.moved += turned + pose.distance_to(self._at.x, self._at.y)
        self._at = pose

    def remembered(self) -> Remembered:
        """Return what is remembered by now, for `restore`."""
        return tuple(array.copy() for array in self._arrays)

    def restore(self, remembered: Remembered) -> None:
        """Forget all that was learnt since."""
        for array, before in zip(self._arrays, remembered, strict=True):
            array[:] = before

    def forget_old(self) -> None:
        """Forget all that was not learnt, or learnt again, lately."""
        old = self.grid.learnt_at < self.grid.moved - LATELY
        self.grid.forget(old)
        self.coverage.looked_at[old] = False

    @property
    def _arrays(self) -> Remembered:
        grid = self.grid
        return grid.evidence, grid.heard_from, grid.learnt_at, self.coverage.looked_at
