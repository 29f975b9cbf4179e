"""A map built from ranges and odometry."""

from __future__ import annotations

from bisect import bisect_right
from typing import Any, NamedTuple

from numpy.typing import NDArray

from robotcore.autonomy.navigation.next_best_view import Coverage
from robotcore.autonomy.navigation.occupancy_grid import OccupancyGrid
from robotcore.autonomy.navigation.planner import Traversability
from robotcore.geometry import Pose, wrap_angle
from robotcore.hal.devices import RangeSensor
from robotcore.hal.robot import Robot

HISTORY_S = 2.0
"""For how long poses are kept; no sample that an app gets is as old."""


class PoseHistory:
    """The poses of the last seconds.

    >>> past = PoseHistory()
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
        forgotten = bisect_right(self._times, time - HISTORY_S)
        del self._times[:forgotten], self._poses[:forgotten]

    def at(self, time: float) -> Pose:
        """Return the pose at a time: between two, on a straight line; beyond them, the nearest."""
        after = bisect_right(self._times, time)
        if after in (0, len(self._times)):
            return self._poses[min(after, len(self._times) - 1)]
        earlier, later = self._poses[after - 1], self._poses[after]
        share = (time - self._times[after - 1]) / (self._times[after] - self._times[after - 1])
        return Pose(*(a + share * (b - a) for a, b in zip(earlier, later, strict=True)))


LATELY = 3.0
"""How much the robot may have moved since, in radians turned and metres driven: odometry still holds as far."""


MapSnapshot = tuple[NDArray[Any], ...]
"""Copies of all that was remembered at some time."""


class MapMemory:
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

    def remembered(self) -> MapSnapshot:
        """Return what is remembered by now, for `restore`."""
        return tuple(array.copy() for array in self._arrays)

    def restore(self, remembered: MapSnapshot) -> None:
        """Forget all that was learnt since."""
        for array, before in zip(self._arrays, remembered, strict=True):
            array[:] = before

    def forget_old(self) -> None:
        """Forget all that was not learnt, or learnt again, lately."""
        old = self.grid.learnt_at < self.grid.moved - LATELY
        self.grid.forget(old)
        self.coverage.looked_at[old] = False

    @property
    def _arrays(self) -> MapSnapshot:
        grid = self.grid
        return grid.evidence, grid.heard_from, grid.learnt_at, self.coverage.looked_at


JUMP_M = 0.15
"""A reading that differs more than this from the one before is of something else, or of nothing."""

BACK_M = 0.05
"""Readings that differ less than this are of the same thing: a tick's way, and some noise."""

SURPRISES = 2
"""So many echoes of one thing in a row, from the midst of what was free, are no accident: the map is wrong."""


class RangeReading(NamedTuple):
    """A distance in metres, that of the sensor's range where nothing was heard, and from where."""

    distance: float
    sensor: Pose

    def differs(self, other: RangeReading, limit: float) -> bool:
        """Return whether the distances differ by more than ``limit``."""
        return abs(self.distance - other.distance) > limit

    def overlaps(self, other: RangeReading, cone: float) -> bool:
        """Return whether what was in the cone at any time between the two was in it at one of them."""
        return abs(wrap_angle(self.sensor.heading - other.sensor.heading)) <= cone / 2


class PendingOutlier(NamedTuple):
    """What was heard, and remembered, before a reading that jumped."""

    heard: RangeReading
    remembered: MapSnapshot


class RangeIntegrator:
    """Takes readings into a memory.

    A reading that jumps, after which the next is again like the one before it, was a false echo, or a lost one, where
    the cone has not turned on meanwhile: what was learnt of it is taken back. Echoes of one thing from the midst of
    what was free, one after the other, say that the robot is not where its wheels have it, or that things have moved:
    then all but what was learnt lately is forgotten.
    """

    def __init__(self, memory: MapMemory) -> None:
        self._memory = memory
        self._last: RangeReading | None = None
        self._doubt: PendingOutlier | None = None
        self._surprises = 0

    def hear(self, sensor: RangeSensor, distance: float, at: Pose) -> bool:
        """Take in what ``sensor`` read when the robot was ``at`` a pose; return whether that made the memory forget."""
        heard = RangeReading(min(distance, sensor.max_range), at.moved(sensor.mount))
        self._settle(heard, sensor.cone)
        if self._last and heard.differs(self._last, JUMP_M):
            self._doubt = PendingOutlier(self._last, self._memory.remembered())
            self._surprises = 0
        self._last = heard
        is_forgotten = self._refutes(heard, sensor.cone, is_echo=distance <= sensor.max_range)
        self._memory.grid.add_range(heard.sensor, distance, sensor.max_range, sensor.cone)
        return is_forgotten

    def _settle(self, heard: RangeReading, cone: float) -> None:
        """Take back what was doubted where this reading contradicts it; else believe it."""
        doubt, self._doubt = self._doubt, None
        if doubt and heard.overlaps(doubt.heard, cone) and not heard.differs(doubt.heard, BACK_M):
            self._memory.restore(doubt.remembered)
            self._last = doubt.heard

    def _refutes(self, heard: RangeReading, cone: float, *, is_echo: bool) -> bool:
        """Forget where echoes refute what was learnt; of what is about this one, all."""
        grid = self._memory.grid
        is_surprise = is_echo and grid.is_refuted_by(heard.sensor, heard.distance, cone)
        self._surprises = self._surprises + 1 if is_surprise else 0
        if self._surprises < SURPRISES:
            return False
        self._memory.forget_old()
        grid.forget_about(heard.sensor, heard.distance, cone)
        return True


NEWS = 0.01
"""Metres or radians by which a reading must differ from the last one."""

BORDER_M = 0.5
"""A robot that is nearer than this to the border of its map leaves it."""


class Map:
    """All that a robot has learnt round the pose at which it began: what is where, what it looked at, where it fits.

    ``reach`` is the radius of the circle that the robot needs to turn on the spot, in metres.
    """

    def __init__(self, pose: Pose, reach: float) -> None:
        self.grid = OccupancyGrid(centre=(pose.x, pose.y))
        self.coverage = Coverage(self.grid)
        self.ground = Traversability(self.grid, reach)
        self._memory = MapMemory(self.grid, self.coverage)
        self._hearing = RangeIntegrator(self._memory)
        self._past = PoseHistory()
        self._heard: tuple[float, ...] | None = None
        self._seen: tuple[float, ...] | None = None

    def is_left_at(self, pose: Pose) -> bool:
        """Return whether the robot leaves the map."""
        return not self.grid.is_within(pose.x, pose.y, BORDER_M)

    def observe(self, robot: Robot, pose: Pose) -> bool:
        """Take in what the robot heard, where it stands and where it looked, each from where it then was.

        Return whether that contradicts what was learnt before, and all but the latest of it is forgotten.

        A reading that repeats the last one, from the same place, is no new evidence.
        """
        self._past.note(robot.clock.now(), pose)
        self._memory.move(pose)
        sensor, camera = robot.range, robot.camera
        reading = sensor.read()
        there, looked_from = self._past.at(reading.time), self._past.at(camera.read().time)
        heard, seen = (*there, reading.distance), (*pose, *looked_from)
        is_heard, is_seen = _is_news(heard, self._heard), _is_news(seen, self._seen)
        is_forgotten = False
        if is_heard:
            self._heard = heard
            is_forgotten = self._hearing.hear(sensor, reading.distance, there)
        if is_heard or is_seen:
            self._seen = seen
            self.grid.add_free_disc(pose.x, pose.y, robot.drive.reach, robot.drive.geometry.track / 2)
            self.coverage.add_view(looked_from.moved(camera.mount), camera.intrinsics.horizontal_fov)
        return is_forgotten


def _is_news(found: tuple[float, ...], last: tuple[float, ...] | None) -> bool:
    return last is None or any(abs(a - b) > NEWS for a, b in zip(found, last, strict=True))
