"""Where the robot was: a sample that comes late belongs to the place where it was taken."""

from __future__ import annotations

from bisect import bisect_right

from robotcore.geometry import Pose

KEPT_S = 2.0
"""For how long poses are kept; no sample that an app gets is as old."""


class Past:
    """The poses of the last seconds.

    >>> past = Past()
    >>> past.note(0.0, Pose(0.0, 0.0, 0.0))
    >>> past.note(0.1, Pose(0.2, 0.0, 0.4))
    >>> past.at(0.05)
    Pose(x=0.1, y=0.0, heading=0.2)
    """

    def __init__(self) -> None:
        self._times: list[float] = []
        self._poses: list[Pose] = []

    def note(self, time: float, pose: Pose) -> None:
        """Keep a pose; times never run backwards."""
        self._times.append(time)
        self._poses.append(pose)
        forgotten = bisect_right(self._times, time - KEPT_S)
        del self._times[:forgotten], self._poses[:forgotten]

    def at(self, time: float) -> Pose:
        """Return the pose at a time: between two, on a straight line; beyond them, the nearest."""
        after = bisect_right(self._times, time)
        if after in (0, len(self._times)):
            return self._poses[min(after, len(self._times) - 1)]
        earlier, later = self._poses[after - 1], self._poses[after]
        share = (time - self._times[after - 1]) / (self._times[after] - self._times[after - 1])
        return Pose(*(a + share * (b - a) for a, b in zip(earlier, later, strict=True)))
