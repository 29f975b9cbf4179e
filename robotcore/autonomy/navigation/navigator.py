"""Explores unknown surroundings and drives to targets in them."""

from __future__ import annotations

from robotcore.autonomy.navigation.mapping import NavigationMap
from robotcore.autonomy.navigation.motion import NO_SCAN, CameraLook, Follower, SensorSurvey, Steering
from robotcore.autonomy.navigation.next_best_view import Viewpoint, best_viewpoint
from robotcore.autonomy.navigation.occupancy_grid import OccupancyGrid, get_corner
from robotcore.autonomy.navigation.planner import (
    NO_PATH,
    NO_PATH_PLAN,
    StopPoint,
    find_straight_starts,
    is_start_known,
    is_unobstructed,
    plan_path,
)
from robotcore.autonomy.navigation.recovery import BlockageDetector, Retreat
from robotcore.canvas import encode_png
from robotcore.geometry import Pose, Twist
from robotcore.hal.robot import Robot

MIN_GOAL_DISTANCE_M = 0.15
"""The least distance from the robot to the goal of a path. The straight path to the target is blocked from here."""

CHECK_BEHIND_M = 0.1
"""The distance from the axle to a point behind it. The robot checks the clearance there to drive backward."""

CLEARANCE_BEHIND_M = 0.12
"""The clearance that the robot needs at the point `CHECK_BEHIND_M` behind the axle to drive backward."""


class Navigator:
    """Maps the surroundings, plans paths over free cells, and follows them.

    Call `observe` once in each tick. Then call one of these methods, which return the velocity for the tick, or None at
    the end of the motion:

    - `look`, after `begin_look`: turn the camera to unseen area.
    - `follow`, after `plan_to` or `plan_to_view`: drive along the planned path.
    - `survey`, after `survey_ahead` or `survey_more`: turn the range sensor to the surroundings.
    - `drive_at`: drive straight to a target.

    speed: the greatest velocity forward, in m/s.
    turn: the greatest turn rate, in rad/s.
    grid: the map to begin with, such as one from `OccupancyGrid.load`; None for a new map. The robot must start at the
        pose at which it started when the map was made.

    >>> from robotcore import Pose
    >>> from robotcore.autonomy.navigation import StopPoint
    >>> navigator = Navigator(speed=0.2, turn=1.0)
    >>> navigator.drive_at(Pose(0.0, 0.0, 0.0), StopPoint(x=2.0, y=0.0, distance=0.3))
    Twist(linear=0.2 m/s, angular=0 rad/s)
    >>> navigator.turn_to(-0.2)
    Twist(linear=0 m/s, angular=-0.5 rad/s)
    """

    def __init__(self, speed: float, turn: float, grid: OccupancyGrid | None = None) -> None:
        self._steering = Steering(speed, turn)
        self._view: Viewpoint | None = None
        self._blockage = BlockageDetector()
        self.pose: Pose | None = None
        """The robot's pose in the last call of `observe`."""
        self._begin_map(Pose(0.0, 0.0, 0.0), reach=0.0, grid=grid)

    def __repr__(self) -> str:
        free, occupied = int(self.map.grid.free.sum()), int(self.map.grid.occupied.sum())
        return f"<Navigator: map of {free} free and {occupied} occupied cells, path of {len(self.path)} cells>"

    def _repr_png_(self) -> bytes:
        return encode_png(self.map.grid.draw(self.pose, self.path))

    @property
    def path(self) -> list[tuple[float, float]]:
        """The points of the planned path that the robot has not reached, in metres; empty without a path."""
        return [self.map.grid.point_of(*cell) for cell in self._follower.path]

    def observe(self, robot: Robot, pose: Pose) -> None:
        """Update the map with the newest samples. Start a new map if the robot is near the border of the old one.

        If the samples contradict the map, the planned path is deleted.

        robot: the robot, with drive, range sensor and camera.
        pose: the robot's pose now, by odometry.
        """
        self.pose = pose
        self.map.ground.reach = robot.drive.reach
        if self.map.is_near_border(pose):
            self.forget(pose)
        if self.map.observe(robot, pose):
            self._follower.start(NO_PATH)

    def forget(self, pose: Pose) -> None:
        """Delete the map, and start a new one around the robot."""
        self._begin_map(pose, self.map.ground.reach)

    def is_blocked(self, robot: Robot, pose: Pose, command: Twist) -> bool:
        """Return whether the robot has not moved for 0.8 s although the app commands a motion.

        The map is then wrong, so a new one is started. `retreat` moves the robot away. Call it once in each tick.

        robot: the robot, with clock and range sensor.
        pose: the robot's pose now, by odometry.
        command: the velocity that the app commanded in the last tick.
        """
        if not self._blockage.observe(robot.clock.now(), pose, command):
            return False
        self.forget(pose)
        self._retreat = Retreat(pose, command, robot.range.read().distance)
        return True

    def retreat(self, pose: Pose) -> Twist | None:
        """Return the velocity of the retreat after `is_blocked`, or None at its end."""
        return self._retreat.velocity(pose, self._steering.turn)

    def begin_look(self, pose: Pose) -> None:
        """Start a turn of the camera to all unseen area that is visible from the pose."""
        self._look = CameraLook(pose.heading)

    def look(self, pose: Pose) -> Twist | None:
        """Return the velocity of the turn to unseen area, or None at its end."""
        return self._turn(self._look.turn_direction(pose.heading, self.map.coverage.unseen_bearings(pose)))

    def plan_to_view(self, pose: Pose) -> bool:
        """Plan a path to the next best view, and return whether there is one.

        Call it after the robot has looked in all directions at the pose.
        """
        self.map.coverage.add_full_turn(pose.x, pose.y)
        self._detour = NO_PATH_PLAN
        self._view = best_viewpoint(self.map.ground, self.map.coverage, self.map.grid.cell_of(pose.x, pose.y))
        self._follower.start(self._view.path if self._view else NO_PATH)
        return self._view is not None

    def plan_to(self, pose: Pose, target: StopPoint) -> bool:
        """Plan a path to a cell from which a straight path leads to a target, and return whether there is one.

        The path ends before the first cell that is not surely free. Return False also if that path is too short. A
        later call may find a path, after a survey here or after a view from another cell.
        """
        goals = find_straight_starts(self.map.grid, target) & ~self.map.grid.disc(pose.x, pose.y, MIN_GOAL_DISTANCE_M)
        here = self.map.grid.cell_of(pose.x, pose.y)
        self._view = None
        self._detour = plan_path(self.map.ground, here, goals, is_surveyed=self._is_surveyed(pose))
        self._follower.start(self._detour.path)
        return bool(self._detour.path.cells)

    def follow(self, pose: Pose) -> Twist | None:
        """Return the velocity along the planned path, or None at its end. Plan the path again if it is blocked.

        A path to a viewpoint also ends as soon as the camera has seen most of the area that is visible from there.
        """
        if self._view and not self._view.is_worth_going(self.map.coverage):
            return None
        return self._follower.follow(pose)

    @property
    def is_at_frontier(self) -> bool:
        """Whether unknown cells follow at the end of the planned path."""
        return bool(self._detour.unknown_part)

    def survey_ahead(self, pose: Pose) -> None:
        """Start a survey of the direction of the unknown cells that follow on the planned path."""
        self._survey = SensorSurvey.ahead(pose, self._detour.compute_unknown_bearing(pose, self.map.ground))

    def survey_more(self, pose: Pose) -> bool:
        """Start the next survey at this pose, and return True. Return False if both surveys have been done here.

        The first is the survey ahead, the second a survey of a full turn.
        """
        if not self._is_surveyed(pose):
            self.survey_ahead(pose)
            return True
        if self._survey.is_full_turn:
            return False
        self._survey = SensorSurvey.full_turn(pose)
        return True

    def survey(self, pose: Pose) -> Twist | None:
        """Return the velocity of the survey's turn, or None at its end."""
        return self._turn(self._survey.turn_direction(pose.heading))

    def is_straight(self, pose: Pose, target: StopPoint) -> bool:
        """Return whether the robot may drive straight to a target.

        No occupied cell may lie on the straight path. The path's first cells must be known to be free, or the robot
        must have done a survey near this pose.
        """
        is_known = self._is_surveyed(pose) or is_start_known(self.map.grid, pose, target)
        return is_known and is_unobstructed(self.map.grid, pose, target)

    def is_known_straight(self, pose: Pose, target: StopPoint) -> bool:
        """Return whether the straight path to a target has no occupied cell, and no unknown cell at its start."""
        return is_start_known(self.map.grid, pose, target) and is_unobstructed(self.map.grid, pose, target)

    def drive_at(self, pose: Pose, target: StopPoint) -> Twist | None:
        """Return the velocity straight to a target, or backward if the robot is too near to the target.

        Return None if an obstacle blocks the way backward.
        """
        gap = target.gap(pose)
        if gap < 0 and not self._is_free_behind(pose):
            return None
        return self._steering.approach(target.bearing(pose), gap)

    def turn_to(self, bearing: float) -> Twist:
        """Return the velocity that turns the robot towards a bearing in radians."""
        return Twist(0.0, self._steering.turn_to(bearing))

    def _begin_map(self, pose: Pose, reach: float, grid: OccupancyGrid | None = None) -> None:
        self.map = NavigationMap(pose, reach, grid)
        self._follower = Follower(self.map.ground, self._steering)
        self._look = CameraLook(pose.heading)
        self._survey = NO_SCAN
        self._view = None
        self._detour = NO_PATH_PLAN

    def _is_surveyed(self, pose: Pose) -> bool:
        return self._survey.is_near(pose, self.map.ground.reach)

    def _is_free_behind(self, pose: Pose) -> bool:
        grid = self.map.grid
        row, column = grid.cell_of(*pose.to_world(-CHECK_BEHIND_M, 0.0))
        window = grid.find_window([(row, column)], CLEARANCE_BEHIND_M)
        top, left = get_corner(window)
        return bool(grid.clearance(window=window)[row - top, column - left] > CLEARANCE_BEHIND_M)

    def _turn(self, sense: float) -> Twist | None:
        return Twist(0.0, sense * self._steering.turn) if sense else None
