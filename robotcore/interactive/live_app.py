"""The app that a live robot runs. It runs the routines of the user, one call after another."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from contextlib import suppress
from typing import Any

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.routines import Routine, race
from robotcore.errors import DeviceError
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot, Role
from robotcore.hal.truth import Truth
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.needs import Need

PATH_STEP_M = 0.01
"""The least distance between two poses of the path, in metres."""


class LiveApp(Behaviour):
    """Runs a routine of the user. In each tick it adds to the robot's path and to the map.

    needs: the devices to open. `robotcore.open` fails if the robot does not have all of them.
    wants: the devices to open if the robot has them.
    """

    def __init__(self, needs: AbstractSet[Need], wants: AbstractSet[Need]) -> None:
        self.needs, self.wants = needs, wants  # type: ignore[misc]  # other apps declare them in their class
        self._routine: Routine[Any] | None = None
        self.truth: Truth | None = None
        """The true state of the simulator. None on a real robot."""
        self.path: list[Pose] = []
        """The robot's poses: the true ones in a simulator with a world, else those of the odometry."""
        self.grid: OccupancyGrid | None = None
        """The map, with poses by the odometry. None without a drive or a range sensor, and before the first tick."""
        self.result: Any = None
        """The result of the last routine."""

    def begin(self, routine: Routine[Any], name: str) -> None:
        """Set the routine that the next ticks run. Its name is the ``state`` of these ticks."""
        self._routine, self.state, self.result = routine, name, None

    def run(self, robot: Robot) -> Routine[Status]:
        assert self._routine
        ended = yield from race(self._routine, self._observe(robot))
        self._observe_once(robot)
        self.result = ended.result
        return Status.SUCCESS

    def _observe(self, robot: Robot) -> Routine[None]:
        while True:
            self._observe_once(robot)
            yield

    def _observe_once(self, robot: Robot) -> None:
        if robot.has(Role.DRIVE):
            with suppress(DeviceError):  # a call that uses the device raises it
                self._add_to_path(self.truth.pose if self.truth else robot.drive.pose)
                self._add_to_map(robot)

    def _add_to_map(self, robot: Robot) -> None:
        if robot.has(Role.RANGE):
            pose, sensor, drive = robot.drive.pose, robot.range, robot.drive
            self.grid = self.grid or OccupancyGrid()
            self.grid.add_range(pose.compose(sensor.mount), sensor.read().distance, sensor.max_range, sensor.cone)
            self.grid.add_free_disc(pose.x, pose.y, drive.reach, drive.inner_reach)

    def _add_to_path(self, pose: Pose) -> None:
        # The last pose is the present one. It replaces its predecessor if that is near the pose before.
        if len(self.path) > 1 and pose.distance_to(self.path[-2].x, self.path[-2].y) < PATH_STEP_M:
            self.path.pop()
        self.path.append(pose)
