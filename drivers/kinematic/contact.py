"""What keeps the body out of things, and counts how often it touched one."""

from __future__ import annotations

import numpy as np

from robotcore.geometry import Pose

from drivers.kinematic.surroundings import Array, Surroundings

RELEASE_M = 0.001
"""A touch is over when the body has drawn back from the thing by this much."""


class Bumper:
    """Says which moves are free, and counts touches: one a thing, however long it lasts.

    Gaps are measured anew only when the body may have moved as far as the smallest of them.
    """

    def __init__(self, surroundings: Surroundings, start: Pose) -> None:
        self.contacts = 0
        self._surroundings = surroundings
        self._touched: dict[int, float] = {}
        self._measure(surroundings.gaps(start))

    def permits(self, here: Pose, there: Pose, travel: float) -> bool:
        """Return whether the body may move; no point of it moves farther than ``travel``.

        Out of a thing it overlaps it may move, deeper in it may not.
        """
        if self._travelled + travel < self._clearance:
            self._travelled += travel
            return True
        ahead = self._surroundings.gaps(there)
        if not ((ahead < 0) & (ahead < self._gaps)).any():
            self._measure(ahead)
            return True
        if self._travelled:
            self._measure(self._surroundings.gaps(here))
        self._touch((ahead < 0) & (ahead < self._gaps))
        return False

    def _measure(self, gaps: Array) -> None:
        self._gaps = gaps
        self._clearance = float(gaps.min(initial=np.inf))
        self._travelled = 0.0
        self._touched = {i: gap for i, gap in self._touched.items() if gaps[i] <= gap + RELEASE_M}

    def _touch(self, is_hit: np.ndarray) -> None:
        for i in np.flatnonzero(is_hit).tolist():
            if i not in self._touched:
                self._touched[i] = float(self._gaps[i])
                self.contacts += 1
