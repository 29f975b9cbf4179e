"""Builds a map from range readings, pictures and odometry."""

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
"""The age at which a pose is deleted from the history. The samples that an app reads are never so old."""


class PoseHistory:
    """The robot's poses of the last two seconds. It gives the pose at the time of a sensor's sample.

    >>> past = PoseHistory()
    >>> past.add(0.0, Pose(0.0, 0.0, 0.0))
    >>> past.add(0.1, Pose(0.2, 0.0, 0.4))
    >>> past.at(0.05)
    Pose(x=0.1, y=0.0, heading=0.2)
    """

    def __init__(self) -> None:
        self._times: list[float] = []
        self._poses: list[Pose] = []

    def add(self, time: float, pose: Pose) -> None:
        """Add a pose with its time in seconds. The time must not be earlier than that of the pose added before."""
        self._times.append(time)
        self._poses.append(pose)
        forgotten = bisect_right(self._times, time - HISTORY_S)
        del self._times[:forgotten], self._poses[:forgotten]

    def at(self, time: float) -> Pose:
        """Return the pose at a time in seconds, by linear interpolation.

        Before the oldest pose of the history, return the oldest pose. After the newest pose, return the newest.
        """
        after = bisect_right(self._times, time)
        if after in (0, len(self._times)):
            return self._poses[min(after, len(self._times) - 1)]
        earlier, later = self._poses[after - 1], self._poses[after]
        share = (time - self._times[after - 1]) / (self._times[after] - self._times[after - 1])
        return Pose(*(a + share * (b - a) for a, b in zip(earlier, later, strict=True)))


LATELY = 3.0
"""The travel, in metres plus radians, after which a reading's position in the map may be wrong by odometry's drift."""


MapSnapshot = tuple[NDArray[Any], ...]
"""Copies of the arrays of a map."""


class MapMemory:
    """An occupancy grid and a coverage map. Both can be reset to a snapshot, and their old cells can be deleted."""

    def __init__(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        self.grid, self.coverage = grid, coverage
        self._at: Pose | None = None

    def move(self, pose: Pose) -> None:
        """Add the travel from the last pose to this one to the grid's ``travelled``."""
        if self._at:
            turned = abs(wrap_angle(pose.heading - self._at.heading))
            self.grid.travelled += turned + pose.distance_to(self._at.x, self._at.y)
        self._at = pose

    def take_snapshot(self) -> MapSnapshot:
        """Return copies of all arrays, for `restore`."""
        return tuple(array.copy() for array in self._arrays)

    def restore(self, snapshot: MapSnapshot) -> None:
        """Set all arrays to a snapshot."""
        for array, before in zip(self._arrays, snapshot, strict=True):
            array[:] = before

    def forget_old(self) -> None:
        """Mark cells as unknown if the robot has travelled more than `LATELY` since their last reading."""
        old = self.grid.updated_at < self.grid.travelled - LATELY
        self.grid.forget(old)
        self.coverage.seen[old] = False

    @property
    def _arrays(self) -> MapSnapshot:
        grid = self.grid
        return grid.evidence, grid.nearest_echo, grid.updated_at, self.coverage.seen


JUMP_M = 0.15
"""A distance that differs by more from the previous one is that of another body, or the sensor detects no body."""

BACK_M = 0.05
"""Distances that differ by less are those of the same body. Noise and the robot's motion in a tick change them."""

SURPRISES = 2
"""The map is wrong after this number of successive echoes from cells that were surely free."""


class RangeReading(NamedTuple):
    """A reading of the range sensor, and the sensor's pose."""

    distance: float
    """The measured distance in metres. Without an echo it is the longest distance that the sensor measures."""
    sensor: Pose
    """The sensor's pose in the odometry's frame."""

    def differs(self, other: RangeReading, limit: float) -> bool:
        """Return whether the distances of two readings differ by more than a limit in metres."""
        return abs(self.distance - other.distance) > limit

    def overlaps(self, other: RangeReading, cone: float) -> bool:
        """Return whether the sensor turned by at most half its cone between two readings.

        The two cones together then cover each direction that the sensor could measure between the readings.
        """
        return abs(wrap_angle(self.sensor.heading - other.sensor.heading)) <= cone / 2


class PendingOutlier(NamedTuple):
    """The state before a reading whose distance jumped. It is restored if that reading was an outlier."""

    reading: RangeReading
    """The reading before the jump."""
    snapshot: MapSnapshot
    """The map before the jump."""


class RangeIntegrator:
    """Adds range readings to a map.

    An outlier is one different reading between two equal readings of a sensor that did not turn. Its cause is a false
    echo or a lost echo, so the map is restored to the state before it. Several successive echoes from cells that were
    surely free mean that odometry has drifted or that bodies have moved. Then the old cells of the map become unknown.
    """

    def __init__(self, memory: MapMemory) -> None:
        self._memory = memory
        self._last: RangeReading | None = None
        self._pending: PendingOutlier | None = None
        self._surprises = 0

    def add(self, sensor: RangeSensor, distance: float, at: Pose) -> bool:
        """Add a reading to the map, and return whether the old cells of the map became unknown.

        sensor: the sensor.
        distance: the measured distance in metres.
        at: the robot's pose at the time of the reading.
        """
        reading = RangeReading(min(distance, sensor.max_range), at.compose(sensor.mount))
        self._undo_outlier(reading, sensor.cone)
        if self._last and reading.differs(self._last, JUMP_M):
            self._pending = PendingOutlier(self._last, self._memory.take_snapshot())
            self._surprises = 0
        self._last = reading
        is_forgotten = self._forget_if_wrong(reading, sensor.cone, is_echo=distance <= sensor.max_range)
        self._memory.grid.add_range(reading.sensor, distance, sensor.max_range, sensor.cone)
        return is_forgotten

    def _undo_outlier(self, reading: RangeReading, cone: float) -> None:
        """Restore the map if this reading shows that the previous one was an outlier."""
        pending, self._pending = self._pending, None
        if pending and reading.overlaps(pending.reading, cone) and not reading.differs(pending.reading, BACK_M):
            self._memory.restore(pending.snapshot)
            self._last = pending.reading

    def _forget_if_wrong(self, reading: RangeReading, cone: float, *, is_echo: bool) -> bool:
        """If echoes contradict the map, mark the old cells and the area of this echo as unknown. Return if so."""
        grid = self._memory.grid
        is_surprise = is_echo and grid.contradicts_echo(reading.sensor, reading.distance, cone)
        self._surprises = self._surprises + 1 if is_surprise else 0
        if self._surprises < SURPRISES:
            return False
        self._memory.forget_old()
        grid.clear_echo(reading.sensor, reading.distance, cone)
        return True


NEWS = 0.01
"""A reading is new evidence if its distance or pose differs from the last by more than this, in metres or radians."""

BORDER_M = 0.5
"""A robot that is nearer to the map's border needs a new map."""


class Map:
    """The robot's map: its free and occupied cells, the cells that the camera has seen, and the traversable cells.

    pose: the robot's pose, at which the middle of the map is.
    reach: the radius of the circle that the robot needs to turn on the spot, in metres.
    """

    def __init__(self, pose: Pose, reach: float) -> None:
        self.grid = OccupancyGrid(centre=(pose.x, pose.y))
        self.coverage = Coverage(self.grid)
        self.ground = Traversability(self.grid, reach)
        self._memory = MapMemory(self.grid, self.coverage)
        self._integrator = RangeIntegrator(self._memory)
        self._past = PoseHistory()
        self._last_reading: tuple[float, ...] | None = None
        self._last_view: tuple[float, ...] | None = None

    def is_left_at(self, pose: Pose) -> bool:
        """Return whether a robot at this pose is less than `BORDER_M` inside the map, so that it needs a new map."""
        return not self.grid.is_within(pose.x, pose.y, BORDER_M)

    def observe(self, robot: Robot, pose: Pose) -> bool:
        """Update the map with the newest samples, and return whether the old cells of the map became unknown.

        Each sample is added at the pose that the robot had at the time of the sample. A reading that equals the last
        one and has the same pose is ignored, because it is no new evidence.

        robot: the robot, with drive, range sensor and camera.
        pose: the robot's pose now, by odometry.
        """
        self._past.add(robot.clock.now(), pose)
        self._memory.move(pose)
        sensor, camera = robot.range, robot.camera
        reading = sensor.read()
        read_at, viewed_at = self._past.at(reading.time), self._past.at(camera.read().time)
        new_reading, new_view = (*read_at, reading.distance), (*pose, *viewed_at)
        is_new_reading = _differs(new_reading, self._last_reading)
        is_new_view = _differs(new_view, self._last_view)
        is_forgotten = False
        if is_new_reading:
            self._last_reading = new_reading
            is_forgotten = self._integrator.add(sensor, reading.distance, read_at)
        if is_new_reading or is_new_view:
            self._last_view = new_view
            self.grid.add_free_disc(pose.x, pose.y, robot.drive.reach, robot.drive.geometry.track / 2)
            self.coverage.add_view(viewed_at.compose(camera.mount), camera.intrinsics.horizontal_fov)
        return is_forgotten


def _differs(values: tuple[float, ...], last: tuple[float, ...] | None) -> bool:
    return last is None or any(abs(a - b) > NEWS for a, b in zip(values, last, strict=True))
