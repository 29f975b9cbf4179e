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
            "arrived": self._rest,
        }[self.state]
        robot.drive.set_velocity(*act(robot, blob))
        is_done = self.state == "arrived" and self._here_for > PATIENCE_S
        return Status.SUCCESS if is_done else Status.RUNNING

    def _search(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn once on the spot; then go where most can be seen that was not looked at."""
        if self._ball.is_in_sight:
            return self._enter("seen")
        if self._turned <= math.tau:
            return Twist(0.0, self.turn_rad_s)
        if self._way.plan_to_view(self._pose):
            return self._enter("explore")
        self._way.forget()
        return self._enter("search")

    def _explore(self, robot: Robot, blob: Blob | None) -> Twist:
        if self._ball.is_in_sight:
            return self._enter("seen")
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
        return STANDING if self._ball.lost_for < PATIENCE_S else self._go_round(robot)

    def _approach(self, robot: Robot, blob: Blob | None) -> Twist:
        """Drive straight at the ball, slower as it comes near."""
        ball = self._ball.place
        if ball is None or self._ball.lost_for > PATIENCE_S:
            return self._enter("seen")
        standing = self._standing_distance(robot)
        if not self._way.is_straight(self._pose, *ball, standing, is_surveyed=self._is_surveyed(robot)):
            return self._go_round(robot)
        bearing, gap = self._pose.bearing_to(*ball), self._pose.distance_to(*ball) - standing
        if blob and abs(gap) < NEAR_M and abs(bearing) < CENTRED_RAD:
            return self._enter("arrived")
        speed = min(self.speed_m_s, 1.5 * gap) if abs(bearing) < 3 * CENTRED_RAD else 0.0
        return Twist(max(speed, -0.05), self._way.turn_to(bearing))

    def _avoid(self, robot: Robot, blob: Blob | None) -> Twist:
        """Follow the way round what stands before the ball."""
        return self._way.follow(self._pose) or self._enter("seen")

    def _survey(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn once on the spot to learn what stands around."""
        return Twist(0.0, self.turn_rad_s) if self._turned <= math.tau else self._enter("seen")

    def _rest(self, robot: Robot, blob: Blob | None) -> Twist:
        """Stand, as long as the ball is in view and its echo is where it should be."""
        is_there = abs(robot.range.read().distance - self.stop_distance_m) < 5 * NEAR_M
        return STANDING if blob and is_there else self._enter("search")

    def _go_round(self, robot: Robot) -> Twist:
        """Plan a way round; where none is known, look round first, then from elsewhere; give up what does not show."""
        ball = self._ball.place
        if ball is None or not self._is_new_sight:
            self._ball.forget()
            return self._enter("search")
        nearest = self._standing_distance(robot) + 0.05
        is_found = self._way.plan_to_ring(self._pose, *ball, nearest, nearest + 0.35)
        if not is_found and not self._is_surveyed(robot):
            self._surveyed_at = self._pose
            return self._enter("survey")
        self._is_new_sight = False
        if is_found or self._way.plan_to_view(self._pose):
            return self._enter("avoid")
        self._way.forget()
        return self._enter("search")

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
        self._turned, self._entered_at = 0.0, self._now
        return STANDING

    @property
    def _here_for(self) -> float:
        """How long the state has lasted, in seconds."""
        return self._now - self._entered_at


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("green-search")
