"""What a robot learns about where it is."""

from __future__ import annotations

from robotcore.geometry import Pose
from robotcore.navigation.coverage import Coverage
from robotcore.navigation.grid import OccupancyGrid
from robotcore.navigation.ground import Ground
from robotcore.robot import Robot

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
        self._heard: tuple[float, ...] | None = None

    def is_left_at(self, pose: Pose) -> bool:
        """Return whether the robot leaves the map."""
        return not self.grid.is_within(pose.x, pose.y, BORDER_M)

    def observe(self, robot: Robot, pose: Pose) -> None:
        """Take in what the robot hears, where it stands and where it looks.

        A reading that repeats the last one, from the same place, is no new evidence.
        """
        reading = (*pose, robot.range.read().distance)
        if not self._heard or any(abs(a - b) > NEWS for a, b in zip(reading, self._heard, strict=True)):
            self._heard = reading
            self._take_in(robot, pose)

    def _take_in(self, robot: Robot, pose: Pose) -> None:
        sensor, camera = robot.range, robot.camera
        self.grid.add_range(pose.moved(sensor.mount), sensor.read().distance, sensor.max_range, sensor.cone)
        self.grid.add_free_disc(pose.x, pose.y, robot.drive.reach, robot.drive.geometry.track / 2)
        self.coverage.add_view(pose.moved(camera.mount), camera.intrinsics.horizontal_fov)
