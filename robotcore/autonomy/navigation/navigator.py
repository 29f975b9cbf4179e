"""A robot that learns its surroundings and finds its way through them."""

from __future__ import annotations

from robotcore.autonomy.navigation.mapping import Map
from robotcore.autonomy.navigation.motion import NO_SWEEP, Follower, ScanTurn, Steering, Sweep
from robotcore.autonomy.navigation.next_best_view import Viewpoint, best_viewpoint
from robotcore.autonomy.navigation.planner import (
    NO_PATH,
    NO_PATH_PLAN,
    Target,
    begins_known,
    is_unobstructed,
    plan_path,
    straight_starts,
)
from robotcore.geometry import Pose, Twist
from robotcore.hal.robot import Robot

HERE_M = 0.15
"""A place nearer than this is no way out: from here it did not go on."""

BACK_M = 0.1
BEHIND_M = 0.12
"""So far behind the axle there must be so much room, for the robot to back off a little."""


class Navigator:
    """Keeps a map in the odometry's frame, looks, plans in what is known to be free, and follows the plan.

    ``speed`` in m/s, ``turn`` in rad/s, both at most. `look`, `follow`, `survey` and `drive_at` return how to move, or
    None where there is nothing more to do that way. The first three are begun: by `begin_look`, by a plan, and by
    `survey_ahead` or `survey_more`.
    """

    def __init__(self, speed: float, turn: float) -> None:
        self._steering = Steering(speed, turn)
        self._view: Viewpoint | None = None
        self._begin_map(Pose(0.0, 0.0, 0.0), reach=0.0)

    def observe(self, robot: Robot, pose: Pose) -> None:
        """Take in what the robot hears and where it looks at ``pose``; begin a new map where it leaves the old one.

        What was planned is void where the map has proved wrong.
        """
        self.map.ground.reach = robot.drive.reach
        if self.map.is_left_at(pose):
            self.forget(pose)
        if self.map.observe(robot, pose):
            self._follower.start(NO_PATH)

    def forget(self, pose: Pose) -> None:
        """Begin a new map, round the robot: what was learnt leads nowhere."""
        self._begin_map(pose, self.map.ground.reach)

    def begin_look(self, pose: Pose) -> None:
        """Begin to look at what can be seen from here and was not looked at."""
        self._look = ScanTurn(pose.heading)

    def look(self, pose: Pose) -> Twist | None:
        """Return how to turn to what was not looked at: in one sense, at most once round. Call it once a tick."""
        return self._turn(self._look.sense(pose.heading, self.map.coverage.unseen_bearings(pose)))

    def plan_to_view(self, pose: Pose) -> bool:
        """Plan to where most can be seen that was not looked at, for the way; return False where there is nothing.

        Call it when the robot has looked all round at ``pose``.
        """
        self.map.coverage.add_look_round(pose.x, pose.y)
        self._detour = NO_PATH_PLAN
        self._view = best_viewpoint(self.map.ground, self.map.coverage, self.map.grid.cell_of(pose.x, pose.y))
        self._follower.start(self._view.way if self._view else NO_PATH)
        return self._view is not None

    def plan_to(self, pose: Pose, target: Target) -> bool:
        """Plan to where the way on to a target is straight, or as far there as is known.

        Return False where that is not far enough to be worth it: a survey, or a view, may show more.
        """
        goals = straight_starts(self.map.grid, target) & ~self.map.grid.disc(pose.x, pose.y, HERE_M)
        here = self.map.grid.cell_of(pose.x, pose.y)
        self._view = None
        self._detour = plan_path(self.map.ground, here, goals, is_surveyed=self._is_surveyed(pose))
        self._follower.start(self._detour.way)
        return bool(self._detour.way.path)

    def follow(self, pose: Pose) -> Twist | None:
        """Return how to move along the plan, made anew where something has come up; None where it is at its end.

        It also ends where what a view was to show has been seen on the way.
        """
        if self._view and not self._view.is_worth_going(self.map.coverage):
            return None
        return self._follower.follow(pose)

    @property
    def is_at_frontier(self) -> bool:
        """Whether the plan, at its end, goes on into what is not known."""
        return bool(self._detour.beyond)

    def survey_ahead(self, pose: Pose) -> None:
        """Begin to turn to and fro over where the plan goes on."""
        self._survey = Sweep.ahead(pose, self._detour.bearing_on(pose, self.map.ground))

    def survey_more(self, pose: Pose) -> bool:
        """Begin to survey what is ahead or, after that, all round; return False where both were done here."""
        if not self._is_surveyed(pose):
            self.survey_ahead(pose)
            return True
        if self._survey.is_all_round:
            return False
        self._survey = Sweep.all_round(pose)
        return True

    def survey(self, pose: Pose) -> Twist | None:
        """Return how to turn on, in the survey that was begun."""
        return self._turn(self._survey.sense(pose.heading))

    def is_straight(self, pose: Pose, target: Target) -> bool:
        """Return whether the straight way to a target is free: where it begins it must be known, or surveyed."""
        is_learnt = self._is_surveyed(pose) or begins_known(self.map.grid, pose, target)
        return is_learnt and is_unobstructed(self.map.grid, pose, target)

    def is_known_straight(self, pose: Pose, target: Target) -> bool:
        """Return whether the straight way to a target is free, and known to be where it begins."""
        return begins_known(self.map.grid, pose, target) and is_unobstructed(self.map.grid, pose, target)

    def drive_at(self, pose: Pose, target: Target) -> Twist | None:
        """Return how to drive straight at a target, or back from it; None where something is behind."""
        gap = target.gap(pose)
        if gap < 0 and not self._is_free_behind(pose):
            return None
        return self._steering.approach(target.bearing(pose), gap)

    def turn_to(self, bearing: float) -> Twist:
        """Return how to turn towards a bearing."""
        return Twist(0.0, self._steering.turn_to(bearing))

    def _begin_map(self, pose: Pose, reach: float) -> None:
        self.map = Map(pose, reach)
        self._follower = Follower(self.map.ground, self._steering)
        self._look = ScanTurn(pose.heading)
        self._survey = NO_SWEEP
        self._view = None
        self._detour = NO_PATH_PLAN

    def _is_surveyed(self, pose: Pose) -> bool:
        """Return whether the robot is still about where it last surveyed."""
        return self._survey.is_about(pose, self.map.ground.reach)

    def _is_free_behind(self, pose: Pose) -> bool:
        behind = self.map.grid.cell_of(*pose.to_world(-BACK_M, 0.0))
        return bool(self.map.grid.clearance()[behind] > BEHIND_M)

    def _turn(self, sense: float) -> Twist | None:
        return Twist(0.0, sense * self._steering.turn) if sense else None
