"""What a robot learns about where it is."""

from __future__ import annotations

from robotcore.autonomy.navigation.coverage import Coverage
from robotcore.autonomy.navigation.grid import OccupancyGrid
from robotcore.autonomy.navigation.ground import Ground
from robotcore.autonomy.navigation.hearing import Hearing
from robotcore.autonomy.navigation.memory import Memory
from robotcore.autonomy.navigation.past import Past
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot

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
        self.ground = Ground(self.grid, reach)
        self._memory = Memory(self.grid, self.coverage)
        self._hearing = Hearing(self._memory)
        self._past = Past()
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
