"""The way round what stands before a target, as far as it is known."""

from __future__ import annotations

from itertools import takewhile
from typing import NamedTuple

import numpy as np

from robotcore.autonomy.navigation.ground import NO_WAY, Ground, Trust, Way
from robotcore.autonomy.navigation.paths import UNREACHED, Cell, Mask, path_back, steps_from
from robotcore.geometry import Pose

SURCHARGE_M = {Trust.KNOWN: 0.0, Trust.UNKNOWN: 0.4, Trust.DOUBTFUL: 1.2}
"""How much longer a way counts for what it leads over: so much may be lost where it does not open."""

NARROW_M = 0.3
"""How much longer a way counts for each margin that is too wide for it."""

WORTH_M = 0.3
"""The known part of a way must be longer than this, for the robot to learn more at its end than it knows here."""

TRIES = 8
"""How many ways are tried, of which all before the last have been barred."""

AHEAD_M = 0.32
"""How far on a way points to where it leads."""


class Detour(NamedTuple):
    """A way as far as it is known, and how it goes on ``beyond`` that."""

    way: Way
    beyond: list[Cell]

    def bearing_on(self, pose: Pose, ground: Ground) -> float:
        """Return in which direction the way goes on beyond what is known; straight ahead where it does not."""
        if not self.beyond:
            return 0.0
        step = min(len(self.beyond) - 1, round(AHEAD_M / ground.grid.cell))
        return pose.bearing_to(*ground.grid.point_of(*self.beyond[step]))


NO_DETOUR = Detour(NO_WAY, [])


class _Candidate(NamedTuple):
    cost: float
    path: list[Cell]
    margin: int


def plan_detour(ground: Ground, here: Cell, goals: Mask, *, is_surveyed: bool) -> Detour:
    """Return the cheapest way to one of ``goals``, as far as it is known; NO_DETOUR where there is none.

    A way of which too little is known is empty: what is ``beyond`` is to be surveyed from here. Where that
    ``is_surveyed`` and did not come to be known, it is barred, and the next cheapest way is tried.
    """
    for _ in range(TRIES):
        candidate = _cheapest(ground, here, goals)
        if candidate is None:
            return NO_DETOUR
        detour = _known_part(ground, candidate)
        if not detour.beyond or len(detour.way.path) * ground.grid.cell > WORTH_M:
            return detour
        if not is_surveyed:
            return Detour(NO_WAY, detour.beyond)
        ground.bar(detour.beyond[0])
    return NO_DETOUR


def _cheapest(ground: Ground, here: Cell, goals: Mask) -> _Candidate | None:
    """Return the cheapest way to a goal: for its length, for what it leads over, and for how narrow it is."""
    candidates = [_shortest(ground, here, goals, trust) for trust in Trust]
    return min(filter(None, candidates), key=lambda candidate: candidate.cost, default=None)


def _shortest(ground: Ground, here: Cell, goals: Mask, trust: Trust) -> _Candidate | None:
    """Return the shortest way to a goal, with the widest margin that leaves one."""
    for margin, mask in enumerate(ground.open_cells(here, trust)):
        steps = steps_from(here, mask, goals)
        at_goals = np.where(goals, steps, UNREACHED)
        goal = divmod(int(at_goals.argmin()), at_goals.shape[1])
        if at_goals[goal] != UNREACHED:
            cost = float(steps[goal]) * ground.grid.cell + SURCHARGE_M[trust] + NARROW_M * margin
            return _Candidate(cost, path_back(steps, goal), margin)
    return None


def _known_part(ground: Ground, candidate: _Candidate) -> Detour:
    """Return a way, parted where it leaves what is known to be free."""
    path = candidate.path
    known_cells = ground.open_cells(path[0])[candidate.margin]
    known = list(takewhile(lambda cell: known_cells[cell], path))
    return Detour(Way(known, known_cells), path[len(known) :])
