"""How far a robot has followed a line, by its true pose."""

from __future__ import annotations

import math

from robotcore.description import Line
from robotcore.description.lines import LineDistances
from robotcore.geometry import Pose


class LineProgress:
    """Measures how a robot follows a line.

    >>> progress = LineProgress(Line(width_m=0.02, points_m=((0.0, 0.0), (2.0, 0.0))))
    >>> for x, y in ((0.0, 0.0), (0.5, 0.03), (1.0, 0.0)):
    ...     progress.update(Pose(x, y, 0.0))
    >>> progress.followed_length, progress.max_distance
    (1.0, 0.03)
    """

    def __init__(self, line: Line) -> None:
        self._line, self._is_closed = LineDistances(line), line.closed
        self._last: float | None = None
        self._travelled = 0.0
        self.max_distance = 0.0
        """The largest distance of the axle's centre from the middle of the line so far, in metres."""

    @property
    def length(self) -> float:
        """The length of the line, of a closed one the length of a lap, in metres."""
        return self._line.length

    @property
    def followed_length(self) -> float:
        """The length of the line along which the robot has driven in one direction, in metres. Laps add up."""
        return abs(self._travelled)

    def update(self, pose: Pose) -> None:
        """Add the true pose of the robot in the next tick."""
        distance, along = self._line.locate(pose.x, pose.y)
        self.max_distance = max(self.max_distance, distance)
        if self._last is not None:
            step = along - self._last
            self._travelled += math.remainder(step, self.length) if self._is_closed else step
        self._last = along
