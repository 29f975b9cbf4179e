"""Search for a green ball, drive to it round whatever stands in the way, and stop in front of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from robotcore.behaviour import Behaviour, Status, Stopping
from robotcore.geometry import Pose, Twist, wrap_angle
from robotcore.navigation import BallTracker, Navigator
from robotcore.robot import Robot, Role
from robotcore.truth import Truth
from robotcore.vision import Blob

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]

STANDING = Twist(0.0, 0.0)
CENTRED_RAD = 0.1
NEAR_M = 0.02
CONFIRM_S = 0.15
PATIENCE_S = 0.5


@dataclass
class GreenSearch(Behaviour):
    """Looks round, explores while nothing is seen, approaches what is, and stops in front of it."""

    hue: str = "green"
    speed_m_s: Positive = 0.25
    turn_rad_s: Positive = 1.5
    stop_distance_m: Positive = 0.28
    ball_radius_m: Positive = 0.10

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})
    wants = frozenset({Role.DISPLAY})
    milestones = ("search", "seen", "approach", "arrived")

    def __post_init__(self) -> None:
        self._ball = BallTracker(self.hue, self.ball_radius_m)
        self._way = Navigator(self.speed_m_s, self.turn_rad_s)
        self._pose = Pose(0.0, 0.0, 0.0)
        self._surveyed_at: Pose | None = None
        self._is_new_sight = False
        self._now = 0.0
        self._enter("search")

    @property
    def stopping(self) -> Stopping:
        return Stopping(self.stop_distance_m, self.speed_m_s)

    def verify(self, truth: Truth) -> bool:
        """At rest, 0.15 to 0.40 m in front of the ball, which is in view."""
        distance = truth.distance_to_target
        is_near = distance is not None and 0.15 <= distance <= 0.40
        return is_near and truth.is_at_rest and truth.sees_target

    def step(self, robot: Robot) -> Status:
        self._locate(robot)
        blob = self._ball.look(robot, self._pose)
        self._is_new_sight |= self._ball.is_in_sight
        act = {
            "search": self._search,
            "explore": self._explore,
            "seen": self._confirm,
            "approach": self._approach,
            "avoid": self._avoid,
            "survey": self._survey,
            "detour": self._detour,
            "arrived": self._rest,
        }[self.state]
        robot.drive.set_velocity(*act(robot, blob))
        is_done = self.state == "arrived" and self._here_for > PATIENCE_S
        return Status.SUCCESS if is_done else Status.RUNNING

    def _search(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn to all that was not looked at; then go where most can be seen that was not."""
        if self._ball.is_in_sight:
            return self._enter("seen")
        bearings = self._way.unseen_bearings(self._pose)
        if len(bearings):
            if not self._sense:
                self._sense = math.copysign(1.0, bearings[abs(bearings).argmin()])
            if ((self._sense * bearings) % math.tau).min() < math.tau - self._turned:
                return Twist(0.0, self._sense * self.turn_rad_s)
        if self._way.plan_to_view(self._pose):
            return self._enter("explore")
        self._way.forget()
        return self._enter("search")

    def _explore(self, robot: Robot, blob: Blob | None) -> Twist:
        if self._ball.is_in_sight:
            return self._enter("seen")
        self._ticks = getattr(self, "_ticks", 0) + 1
        if self._ticks % 20 == 0 and not self._way.is_worth_going():
            return self._enter("search")
        return self._way.follow(self._pose) or self._enter("search")

    def _confirm(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn towards where the ball should be until it has proved to be there."""
        if self._ball.place is None:
            return self._enter("search")
        bearing = blob.bearing if blob else self._pose.bearing_to(*self._ball.place)
        if abs(bearing) > CENTRED_RAD or self._here_for < CONFIRM_S:
            return Twist(0.0, self._way.turn_to(bearing))
        if blob:
            return self._enter("approach")
        if self._ball.lost_for < PATIENCE_S:
            return STANDING
        if self._way.is_straight(self._pose, *self._ball.place, self._standing_distance(robot), is_surveyed=False):
            self._ball.forget()
            return self._enter("search")
        return self._go_round(robot)

    def _approach(self, robot: Robot, blob: Blob | None) -> Twist:
        """Drive straight at the ball, slower as it comes near."""
        ball = self._ball.place
        if ball is None or self._ball.lost_for > PATIENCE_S:
            return self._enter("seen")
        standing = self._standing_distance(robot)
        if not self._way.is_straight(self._pose, *ball, standing, is_surveyed=self._is_surveyed(robot)):
            return self._go_round(robot)
        bearing, gap = self._pose.bearing_to(*ball), self._pose.distance_to(*ball) - standing
        if blob and -3 * NEAR_M < gap < NEAR_M and abs(bearing) < CENTRED_RAD:
            return self._enter("arrived")
        if gap < 0 and not self._way.is_free_behind(self._pose):
            return self._go_round(robot)
        speed = min(self.speed_m_s, 1.5 * gap) if abs(bearing) < 3 * CENTRED_RAD else 0.0
        return Twist(max(speed, -0.05), self._way.turn_to(bearing))

    def _avoid(self, robot: Robot, blob: Blob | None) -> Twist:
        """Follow the way round what stands before the ball."""
        if (twist := self._way.follow(self._pose)) is not None:
            return twist
        if self._way._ahead:
            return self._survey_ahead()
        return self._enter("seen")

    def _detour(self, robot: Robot, blob: Blob | None) -> Twist:
        """Go where more can be learnt; then look for a way again."""
        return self._way.follow(self._pose) or self._enter("seen")

    def _survey_ahead(self) -> Twist:
        self._surveyed_at = self._pose
        self._is_all_round = False
        ahead = self._pose.heading + self._way.bearing_ahead(self._pose)
        self._headings = [ahead + 0.8, ahead - 0.8]
        if abs(wrap_angle(self._headings[1] - self._pose.heading)) < abs(wrap_angle(self._headings[0] - self._pose.heading)):
            self._headings.reverse()
        return self._enter("survey")

    def _survey(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn to and fro to learn what stands ahead."""
        while self._headings:
            bearing = wrap_angle(self._headings[0] - self._pose.heading)
            if abs(bearing) > 0.1:
                return Twist(0.0, math.copysign(self.turn_rad_s, bearing))
            self._headings.pop(0)
        return self._go_round(robot)

    def _rest(self, robot: Robot, blob: Blob | None) -> Twist:
        """Stand, as long as the ball is in view and its echo is where it should be."""
        is_there = abs(robot.range.read().distance - self.stop_distance_m) < 5 * NEAR_M
        return STANDING if blob and is_there else self._enter("search")

    def _go_round(self, robot: Robot) -> Twist:
        """Plan a way round; where none is known, look round first, then from elsewhere; give up what does not show."""
        ball = self._ball.place
        if ball is None:
            return self._enter("search")
        nearest = self._standing_distance(robot) + 0.05
        is_surveyed = self._is_surveyed(robot)
        if self._way.plan_to_ring(self._pose, *ball, nearest, nearest + 0.35, is_surveyed=is_surveyed):
            return self._enter("avoid")
        if not is_surveyed:
            return self._survey_ahead()
        if not self._is_all_round:
            return self._survey_round()
        if self._way.plan_to_view(self._pose):
            return self._enter("detour")
        self._way.forget()
        self._ball.forget()
        self._surveyed_at = None
        return self._enter("search")

    def _survey_round(self) -> Twist:
        self._surveyed_at = self._pose
        self._is_all_round = True
        self._headings = [self._pose.heading + part * math.tau / 3 for part in (1, 2, 3)]
        return self._enter("survey")

    def _is_surveyed(self, robot: Robot) -> bool:
        """Return whether the robot has just looked all round, about where it is."""
        at = self._surveyed_at
        return at is not None and self._pose.distance_to(at.x, at.y) < robot.drive.reach

    def _standing_distance(self, robot: Robot) -> float:
        """From the axle to the ball's middle, when the robot stands where it means to."""
        return robot.range.mount.x + self.stop_distance_m + self.ball_radius_m

    def _locate(self, robot: Robot) -> None:
        """Learn where the robot is and what is before it."""
        pose = robot.drive.pose
        self._turned += abs(wrap_angle(pose.heading - self._pose.heading))
        self._pose = pose
        self._now = robot.clock.now()
        self._way.observe(robot, pose)

    def _enter(self, state: str) -> Twist:
        """Begin a state, standing."""
        self.state = state
        self._sense = 0.0
        self._turned, self._entered_at = 0.0, self._now
        return STANDING

    @property
    def _here_for(self) -> float:
        """How long the state has lasted, in seconds."""
        return self._now - self._entered_at


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("green-search")
