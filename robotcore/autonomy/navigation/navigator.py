"""Explores unknown surroundings and drives to targets in them."""

from __future__ import annotations

from robotcore.autonomy.navigation.mapping import Map
from robotcore.autonomy.navigation.motion import NO_SWEEP, Follower, ScanTurn, Steering, Sweep
from robotcore.autonomy.navigation.next_best_view import Viewpoint, best_viewpoint
from robotcore.autonomy.navigation.planner import (
    NO_PATH,
    NO_PATH_PLAN,
    Target,
    find_straight_starts,
    is_start_known,
    is_unobstructed,
    plan_path,
)
from robotcore.geometry import Pose, Twist
from robotcore.hal.robot import Robot

HERE_M = 0.15
"""A goal of a path must be farther away, because the robot has found no straight path to the target from here."""

BACK_M = 0.1
"""The distance behind the axle at which the clearance is checked before the robot drives backward."""

BEHIND_M = 0.12
"""The clearance at that distance behind the axle that the robot needs to drive backward."""


class Navigator:
    """Maps the surroundings, plans paths over free cells, and follows them.

    Call `observe` once in each tick. `look`, `follow`, `survey` and `drive_at` return the velocity for the tick, or
    None at the end of the motion. Call `begin_look` before `look`. Call `plan_to` or `plan_to_view` before `follow`.
    Call `survey_ahead` or `survey_more` before `survey`.

    speed: the greatest velocity forward, in m/s.
    turn: the greatest velocity of a turn, in rad/s.

    >>> navigator = Navigator(speed=0.2, turn=1.0)
    >>> navigator.drive_at(Pose(0.0, 0.0, 0.0), Target(x=2.0, y=0.0, distance=0.3))
    Twist(linear=0.2, angular=0.0)
    >>> navigator.turn_to(-0.2)
    Twist(linear=0.0, angular=-0.5)
    """

    def __init__(self, speed: float, turn: float) -> None:
        self._steering = Steering(speed, turn)
        self._view: Viewpoint | None = None
        self._begin_map(Pose(0.0, 0.0, 0.0), reach=0.0)

    def observe(self, robot: Robot, pose: Pose) -> None:
        """Update the map with the newest samples. If the robot leaves the map, start a new map.

        If the samples contradict the map, the plan is deleted.

        robot: the robot, with drive, range sensor and camera.
        pose: the robot's pose now, by odometry.
        """
        self.map.ground.reach = robot.drive.reach
        if self.map.is_left_at(pose):
            self.forget(pose)
        if self.map.observe(robot, pose):
            self._follower.start(NO_PATH)

    def forget(self, pose: Pose) -> None:
        """Start a new map around the robot."""
        self._begin_map(pose, self.map.ground.reach)

    def begin_look(self, pose: Pose) -> None:
        """Start a turn to all bearings at which area that the camera has not seen is visible from the pose."""
        self._look = ScanTurn(pose.heading)

    def look(self, pose: Pose) -> Twist | None:
        """Return the velocity of the turn to unseen area, or None at its end. Call it once in each tick."""
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

    def plan_to(self, pose: Pose, target: Target) -> bool:
        """Plan a path to a cell from which a straight path leads to a target, and return whether there is one.

        The path ends at the first cell that is not surely free. Return False also if the path up to there is too short.
        After a survey or a view from another cell, there may be a path.
        """
        goals = find_straight_starts(self.map.grid, target) & ~self.map.grid.disc(pose.x, pose.y, HERE_M)
        here = self.map.grid.cell_of(pose.x, pose.y)
        self._view = None
        self._detour = plan_path(self.map.ground, here, goals, is_surveyed=self._is_surveyed(pose))
        self._follower.start(self._detour.path)
        return bool(self._detour.path.cells)

    def follow(self, pose: Pose) -> Twist | None:
        """Return the velocity along the planned path, or None at its end. If the path is blocked, plan it again.

        A path to a view also ends if the camera has already seen most of the area that is visible from there.
        """
        if self._view and not self._view.is_worth_going(self.map.coverage):
            return None
        return self._follower.follow(pose)

    @property
    def is_at_frontier(self) -> bool:
        """Whether the planned path continues over unknown cells."""
        return bool(self._detour.unknown_part)

    def survey_ahead(self, pose: Pose) -> None:
        """Start a survey of the direction in which the planned path continues."""
        self._survey = Sweep.ahead(pose, self._detour.bearing_on(pose, self.map.ground))

    def survey_more(self, pose: Pose) -> bool:
        """Start a survey ahead, or a survey of a full turn if the survey ahead has been done here.

        Return False if both have been done here.
        """
        if not self._is_surveyed(pose):
            self.survey_ahead(pose)
            return True
        if self._survey.is_all_round:
            return False
        self._survey = Sweep.all_round(pose)
        return True

    def survey(self, pose: Pose) -> Twist | None:
        """Return the velocity of the survey's turn, or None at its end."""
        return self._turn(self._survey.turn_direction(pose.heading))

    def is_straight(self, pose: Pose, target: Target) -> bool:
        """Return whether the robot may drive straight to a target.

        No occupied cell may lie on the straight path. Its start must consist of free cells, or the robot must have
        surveyed it from here.
        """
        is_known = self._is_surveyed(pose) or is_start_known(self.map.grid, pose, target)
        return is_known and is_unobstructed(self.map.grid, pose, target)

    def is_known_straight(self, pose: Pose, target: Target) -> bool:
        """Return whether no occupied cell lies on the straight path to a target and its start has no unknown cells."""
        return is_start_known(self.map.grid, pose, target) and is_unobstructed(self.map.grid, pose, target)

    def drive_at(self, pose: Pose, target: Target) -> Twist | None:
        """Return the velocity straight to a target, or backward if the robot is too near to it.

        Return None if the robot would have to drive backward and there is an obstacle behind it.
        """
        gap = target.gap(pose)
        if gap < 0 and not self._is_free_behind(pose):
            return None
        return self._steering.approach(target.bearing(pose), gap)

    def turn_to(self, bearing: float) -> Twist:
        """Return the velocity of a turn towards a bearing in radians."""
        return Twist(0.0, self._steering.turn_to(bearing))

    def _begin_map(self, pose: Pose, reach: float) -> None:
        self.map = Map(pose, reach)
        self._follower = Follower(self.map.ground, self._steering)
        self._look = ScanTurn(pose.heading)
        self._survey = NO_SWEEP
        self._view = None
        self._detour = NO_PATH_PLAN

    def _is_surveyed(self, pose: Pose) -> bool:
        """Return whether the robot is near the position of its last survey."""
        return self._survey.is_near(pose, self.map.ground.reach)

    def _is_free_behind(self, pose: Pose) -> bool:
        behind = self.map.grid.cell_of(*pose.to_world(-BACK_M, 0.0))
        return bool(self.map.grid.clearance()[behind] > BEHIND_M)

    def _turn(self, sense: float) -> Twist | None:
        return Twist(0.0, sense * self._steering.turn) if sense else None
