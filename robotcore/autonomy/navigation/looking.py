"""Turning on the spot to look: round to what was not looked at, and to and fro to learn what stands ahead."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from robotcore.autonomy.navigation.rays import Angles
from robotcore.geometry import Pose, wrap_angle

TURNED_RAD = 0.1
"""A heading that is nearer than this has been turned to."""

AHEAD_RAD = 0.8
"""How far a sweep turns to either side of what is ahead."""


class Look:
    """A turn in one sense, at most once round, past bearings that are worth looking at."""

    def __init__(self, heading: float) -> None:
        self._heading = heading
        self._turned = 0.0
        self._sense = 0.0

    def sense(self, heading: float, bearings: Angles) -> float:
        """Return 1 to go on to the left, -1 to the right, 0 where no bearing is left. Call it once a tick."""
        self._turned += abs(wrap_angle(heading - self._heading))
        self._heading = heading
        if not bearings.size:
            return 0.0
        self._sense = self._sense or math.copysign(1.0, bearings[np.abs(bearings).argmin()])
        is_left = (self._sense * bearings % math.tau).min() < math.tau - self._turned
        return self._sense if is_left else 0.0


class Survey:
    """Headings to turn through, one after the other, so that the range sensor hears what stands about a place."""

    def __init__(self, at: Pose, headings: Iterable[float], *, is_all_round: bool = False) -> None:
        self.is_all_round = is_all_round
        self._at = at
        self._headings = list(headings)

    @classmethod
    def ahead(cls, at: Pose, bearing: float) -> Survey:
        """Return a sweep over what lies at a bearing, its nearer side first."""
        middle = at.heading + bearing
        sides = middle + AHEAD_RAD, middle - AHEAD_RAD
        return cls(at, sorted(sides, key=lambda side: abs(wrap_angle(side - at.heading))))

    @classmethod
    def all_round(cls, at: Pose) -> Survey:
        """Return a whole turn."""
        return cls(at, (at.heading + part * math.tau / 3 for part in (1, 2, 3)), is_all_round=True)

    def is_about(self, pose: Pose, reach: float) -> bool:
        """Return whether what was learnt holds for a robot at ``pose``: it has not moved on by its own ``reach``."""
        return pose.distance_to(self._at.x, self._at.y) < reach

    def sense(self, heading: float) -> float:
        """Return 1 to turn left, -1 to turn right, 0 where all headings were turned to."""
        while self._headings:
            bearing = wrap_angle(self._headings[0] - heading)
            if abs(bearing) > TURNED_RAD:
                return math.copysign(1.0, bearing)
            self._headings.pop(0)
        return 0.0


NO_SURVEY = Survey(Pose(math.inf, math.inf, 0.0), ())
