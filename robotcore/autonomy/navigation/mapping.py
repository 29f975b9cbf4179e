"""Builds a map from range readings, pictures and odometry."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import Any, NamedTuple

from numpy.typing import NDArray

from robotcore.autonomy.navigation.next_best_view import Coverage
from robotcore.autonomy.navigation.occupancy_grid import OccupancyGrid
from robotcore.autonomy.navigation.planner import Traversability
from robotcore.geometry import Pose, wrap_angle
from robotcore.hal.robot import Robot
from robotcore.kinds.range_sensor import Range, RangeSensor

HISTORY_S = 2.0
"""The age at which a pose is deleted from the history, in s. The samples that an app reads are newer."""


class PoseHistory:
    """The poses of the robot, or of a sensor on it, of the last two seconds, to look up the pose at a sample's time.

    >>> past = PoseHistory()
    >>> past.add(0.0, Pose(0.0, 0.0, 0.0))
    >>> past.add(0.1, Pose(0.2, 0.0, 0.4))
    >>> past.at(0.05)
    Pose(x=0.1 m, y=0 m, heading=0.2 rad)
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


DRIFT_LIMIT = 3.0
"""The robot's motion since a reading, in metres plus radians, after which odometry may have drifted too far.

If echoes contradict the map, `MapMemory.forget_old` deletes such readings.
"""


MapSnapshot = tuple[NDArray[Any], ...]
"""Copies of the arrays of a map."""


class MapMemory:
    """The arrays of an occupancy grid and of a coverage map, with methods to restore them and to clear old cells."""

    def __init__(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        self.grid, self.coverage = grid, coverage
        self._at: Pose | None = None

    def move(self, pose: Pose) -> None:
        """Add the motion from the last pose to this one to the grid's ``travelled``."""
        if self._at:
            turned = abs(wrap_angle(pose.heading - self._at.heading))
            self.grid.travelled += turned + pose.distance_to(self._at.x, self._at.y)
        self._at = pose

    def take_snapshot(self) -> MapSnapshot:
        """Return copies of all arrays, for `restore`."""
        return tuple(array.copy() for array in self._arrays)

    def restore(self, snapshot: MapSnapshot) -> None:
        """Copy a snapshot into the arrays."""
        for array, before in zip(self._arrays, snapshot, strict=True):
            array[:] = before

    def forget_old(self) -> None:
        """Mark cells as unknown if the robot has travelled more than `DRIFT_LIMIT` since their last reading."""
        old = self.grid.updated_at < self.grid.travelled - DRIFT_LIMIT
        self.grid.forget(old)
        self.coverage.seen[old] = False

    @property
    def _arrays(self) -> MapSnapshot:
        grid = self.grid
        return grid.evidence, grid.nearest_echo, grid.updated_at, self.coverage.seen


JUMP_M = 0.15
"""Two successive distances that differ by more than this, in metres, come from different bodies."""

SAME_BODY_M = 0.05
"""Two distances that differ by less than this, in metres, come from the same body.

The difference comes from noise and from the robot's motion between the readings.
"""

MAX_CONTRADICTIONS = 2
"""After this number of successive echoes from surely free cells, the map is wrong and its old cells are deleted."""


class RangeReading(NamedTuple):
    """A reading of the range sensor, and the sensor's pose."""

    distance: float
    """The measured distance in metres. Without an echo it is the sensor's range."""
    sensor: Pose
    """The sensor's pose in the odometry's frame."""

    def differs(self, other: RangeReading, limit: float) -> bool:
        """Return whether the distances of two readings differ by more than a limit in metres."""
        return abs(self.distance - other.distance) > limit

    def overlaps(self, other: RangeReading, cone: float) -> bool:
        """Return whether the sensor turned by at most half of its cone between two readings.

        cone: the full opening angle of the cone in radians.
        """
        return abs(wrap_angle(self.sensor.heading - other.sensor.heading)) <= cone / 2


class PendingOutlier(NamedTuple):
    """The last reading and the map before a reading that may be an outlier."""

    reading: RangeReading
    """The reading before the possible outlier."""
    snapshot: MapSnapshot
    """The map before the possible outlier."""


class RangeIntegrator:
    """Adds range readings to a map.

    An outlier is one different reading between two equal readings of a sensor that did not turn. It comes from a false
    or a lost echo, so the integrator restores the map before it. `MAX_CONTRADICTIONS` successive echoes from surely
    free cells mean that odometry has drifted or that bodies have moved. Then the old cells of the map become unknown.
    """

    def __init__(self, memory: MapMemory) -> None:
        self._memory = memory
        self._last: RangeReading | None = None
        self._pending: PendingOutlier | None = None
        self._contradictions = 0

    def add(self, sensor: RangeSensor, distance: float, at: Pose, since: Pose | None = None) -> bool:
        """Add a reading to the map, and return whether the old cells of the map became unknown.

        sensor: the sensor.
        distance: the measured distance in metres.
        at: the sensor's pose at the time of the reading, in the odometry's frame.
        since: the sensor's pose at the first of the successive readings without an echo, if one alone may be lost. Only
            the cells that are in the cone from this pose to ``at`` become free.
        """
        reading = RangeReading(min(distance, sensor.max_range), at)
        self._undo_outlier(reading, sensor.cone)
        if self._last and reading.differs(self._last, JUMP_M):
            self._pending = PendingOutlier(self._last, self._memory.take_snapshot())
            self._contradictions = 0
        self._last = reading
        is_forgotten = self._forget_contradicted(reading, sensor.cone, is_echo=distance <= sensor.max_range)
        common, cone = _intersect_cones(since or at, at, sensor.cone)
        self._memory.grid.add_range(common, distance, sensor.max_range, cone, sensor.noise)
        return is_forgotten

    def _undo_outlier(self, reading: RangeReading, cone: float) -> None:
        pending, self._pending = self._pending, None
        if pending and reading.overlaps(pending.reading, cone) and not reading.differs(pending.reading, SAME_BODY_M):
            self._memory.restore(pending.snapshot)
            self._last = pending.reading

    def _forget_contradicted(self, reading: RangeReading, cone: float, *, is_echo: bool) -> bool:
        """Mark old cells and the area of this echo as unknown if echoes contradict the map. Return whether they do."""
        grid = self._memory.grid
        is_contradiction = is_echo and grid.contradicts_echo(reading.sensor, reading.distance, cone)
        self._contradictions = self._contradictions + 1 if is_contradiction else 0
        if self._contradictions < MAX_CONTRADICTIONS:
            return False
        self._memory.forget_old()
        grid.clear_echo(reading.sensor, reading.distance, cone)
        return True


def _intersect_cones(first: Pose, last: Pose, cone: float) -> tuple[Pose, float]:
    """Return the direction and the angle of the cone that a sensor covered all the time between two poses."""
    if first == last:
        return last, cone
    middle = Pose(*((a + b) / 2 for a, b in zip(first, last, strict=True)))
    return middle, max(0.0, cone - abs(wrap_angle(last.heading - first.heading)))


class MissingEchoes:
    """Finds the successive samples without an echo that show together that nothing is in range.

    A run repeats an echo until as many samples without an echo have followed as the sensor needs. So the first of these
    samples that an app reads is the last of several.

    >>> missing = MissingEchoes()
    >>> missing.find_start(Range(0.8, time=1.0, sequence=10), samples=3)
    1.0
    >>> round(missing.find_start(Range(math.inf, time=1.3, sequence=13), samples=3), 2)
    1.1
    """

    def __init__(self) -> None:
        self._last: Range | None = None
        self._count = 0
        self._start: float | None = None

    def find_start(self, reading: Range, samples: int) -> float | None:
        """Return the time of the first sample that shows the same as this one, in seconds.

        That is the time of the reading itself, if it has an echo, or if the sensor loses none. Return None if too few
        samples without an echo have followed each other.

        samples: the number of samples in a row without an echo that show that nothing is in range.
        """
        last, self._last = self._last, reading
        if last and last.sequence == reading.sequence:
            return self._start
        if samples == 1 or not math.isinf(reading.distance):
            self._count, self._start = 0, reading.time
            return self._start
        is_first = last is not None and not math.isinf(last.distance)
        passed = min(reading.sequence - last.sequence, samples) if last and is_first else 1
        self._count += passed
        period = (reading.time - last.time) / passed if last else 0.0
        self._start = reading.time - (samples - 1) * period if self._count >= samples else None
        return self._start


MIN_CHANGE = 0.01
"""A reading counts only if its distance or pose differs from the last by more than this, in metres or radians."""

BORDER_M = 0.5
"""A robot that is nearer than this to the map's border needs a new map."""


class NavigationMap:
    """The robot's map: its free and occupied cells, the cells that the camera has seen, and the traversable cells.

    pose: the robot's pose; its position becomes the middle of the map.
    reach: the radius in metres of the circle that the robot covers when it turns on the spot.
    grid: the cells to begin with; None for a new map, of which all cells are unknown.
    """

    def __init__(self, pose: Pose, reach: float, grid: OccupancyGrid | None = None) -> None:
        self.grid = OccupancyGrid(centre=(pose.x, pose.y)) if grid is None else grid
        self.coverage = Coverage(self.grid)
        self.ground = Traversability(self.grid, reach)
        self._memory = MapMemory(self.grid, self.coverage)
        self._integrator = RangeIntegrator(self._memory)
        self._past, self._sensor_mounts, self._camera_mounts = PoseHistory(), PoseHistory(), PoseHistory()
        self._missing_echoes = MissingEchoes()
        self._last_reading: tuple[float, ...] | None = None
        self._last_view: tuple[float, ...] | None = None

    def is_near_border(self, pose: Pose) -> bool:
        """Return whether a robot at this pose is less than `BORDER_M` from the map's border, or outside the map."""
        return not self.grid.is_within(pose.x, pose.y, BORDER_M)

    def observe(self, robot: Robot, pose: Pose) -> bool:
        """Update the map with the newest samples, and return whether the old cells of the map became unknown.

        Each sample belongs to the poses of the robot and of the sensor at the time of the sample. A reading with the
        same distance and pose as the last one adds nothing to the map.

        robot: the robot, with drive, range sensor and camera.
        pose: the robot's pose now, by odometry.
        """
        now, sensor, camera = robot.clock.now(), robot.range, robot.camera
        self._past.add(now, pose)
        self._sensor_mounts.add(now, sensor.mount)
        self._camera_mounts.add(now, camera.mount)
        self._memory.move(pose)
        reading, viewed_s = sensor.read(), camera.read().time
        read_at, sensor_mount = self._past.at(reading.time), self._sensor_mounts.at(reading.time)
        viewed_at, camera_mount = self._past.at(viewed_s), self._camera_mounts.at(viewed_s)
        new_reading = (*read_at, *sensor_mount, reading.distance)
        new_view = (*pose, *viewed_at, *camera_mount)
        since = self._missing_echoes.find_start(reading, sensor.echo_free_samples)
        is_new_reading = since is not None and _differs(new_reading, self._last_reading)
        is_new_view = _differs(new_view, self._last_view)
        is_forgotten = False
        if since is not None and is_new_reading:
            self._last_reading = new_reading
            at = begun_at = read_at.compose(sensor_mount)
            if since != reading.time:
                begun_at = self._past.at(since).compose(self._sensor_mounts.at(since))
            is_forgotten = self._integrator.add(sensor, reading.distance, at, begun_at)
        if is_new_reading or is_new_view:
            self._last_view = new_view
            self.grid.add_free_disc(pose.x, pose.y, robot.drive.reach, robot.drive.inner_reach)
            self.coverage.add_view(viewed_at.compose(camera_mount), camera.intrinsics.horizontal_fov)
        return is_forgotten


def _differs(values: tuple[float, ...], last: tuple[float, ...] | None) -> bool:
    return last is None or any(abs(a - b) > MIN_CHANGE for a, b in zip(values, last, strict=True))
