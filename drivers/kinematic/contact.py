"""What keeps the body out of things, and counts how often it touched one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.kinematic.surroundings import Surroundings
from robotcore.geometry import Pose
from robotcore.hal.truth import RELEASE_M
from robotcore.simulation.painter.planes import Array


class Bumper:
    """Says which moves are free, and counts touches: one a thing, however long it lasts.

    Gaps are measured anew only when the body may have moved as far as the smallest of them.
    """

    def __init__(self, surroundings: Surroundings, start: Pose) -> None:
        self.contacts = 0
        self._surroundings = surroundings
        self._reach = surroundings.reach
        self._touched: dict[int, float] = {}
        self._measure(surroundings.gaps(start))

    def permits(self, here: Pose, there: Pose, distance: float, turn: float) -> bool:
        """Return whether the body may roll ``distance`` metres while turning by ``turn``, neither below zero.

        Out of a thing it overlaps it may move, deeper in it may not.
        """
        travel = distance + turn * self._reach
        if self._travelled + travel < self._clearance:
            self._travelled += travel
            return True
        ahead = self._surroundings.gaps(there)
        is_hit = (ahead < 0) & (ahead < self._gaps)
        if not is_hit.any():
            self._measure(ahead)
            return True
        if self._travelled:
            self._measure(self._surroundings.gaps(here))
        self._touch(is_hit)
        return False

    def _measure(self, gaps: Array) -> None:
        self._gaps = gaps
        self._clearance = float(gaps.min(initial=np.inf))
        self._travelled = 0.0
        self._touched = {i: gap for i, gap in self._touched.items() if gaps[i] <= gap + RELEASE_M}

    def _touch(self, is_hit: NDArray[np.bool_]) -> None:
        for i in np.flatnonzero(is_hit).tolist():
            if i not in self._touched:
                self._touched[i] = float(self._gaps[i])
                self.contacts += 1
