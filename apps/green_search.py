"""Search for a green ball, drive to it round whatever stands in the way, and stop in front of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from robotcore.behaviour import Behaviour, Status, Stopping
from robotcore.geometry import Pose, Twist, wrap_angle
from robotcore.navigation import Navigator
from robotcore.robot import Robot, Role
from robotcore.truth import Truth
from robotcore.vision import Blob, ColourDetector, marked

Positive = Annotated[float, Field(gt=0)]

STANDING = Twist(0.0, 0.0)
CENTRED_RAD = 0.1
CONFIRM_TICKS = 3
PATIENCE_TICKS = 10
SEEN_PX = 30
KEPT_PX = 8


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
        self._detector = ColourDetector(self.hue, min_area=KEPT_PX)
        self._way = Navigator(self.speed_m_s, self.turn_rad_s)
        self._pose = Pose(0.0, 0.0, 0.0)
        self._ball: tuple[float, float] | None = None
        self._is_sighted = False
        self._surveyed_at: Pose | None = None
        self._ticks_lost = 0
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
        blob = self._look(robot)
        twist = {
            "search": self._search,
            "explore": self._explore,
            "seen": self._confirm,
            "approach": self._approach,
            "avoid": self._avoid,
            "survey": self._survey,
            "arrived": self._rest,
        }[self.state](robot, blob)
        robot.drive.set_velocity(*twist)
        is_done = self.state == "arrived" and self._ticks_here > PATIENCE_TICKS
        return Status.SUCCESS if is_done else Status.RUNNING

    def _search(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn once on the spot; then go where most that is unknown can be seen."""
        if blob and blob.area >= SEEN_PX:
            return self._enter("seen")
        if self._turned <= math.tau:
            return Twist(0.0, self.turn_rad_s)
        if self._way.plan_to_view(self._pose):
            return self._enter("explore")
        self._way.forget()
        return self._enter("search")

    def _explore(self, robot: Robot, blob: Blob | None) -> Twist:
        if blob and blob.area >= SEEN_PX:
            return self._enter("seen")
        return self._way.follow(self._pose) or self._enter("search")

    def _confirm(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn towards where the ball should be until it has proved to be there."""
        if self._ball is None:
            return self._enter("search")
        bearing = blob.bearing if blob else self._pose.bearing_to(*self._ball)
        if abs(bearing) > CENTRED_RAD or self._ticks_here < CONFIRM_TICKS:
            return Twist(0.0, self._way.turn_to(bearing))
        if blob:
            return self._enter("approach")
        return STANDING if self._ticks_lost < PATIENCE_TICKS else self._go_round(robot)

    def _approach(self, robot: Robot, blob: Blob | None) -> Twist:
        """Drive straight at the ball, slower as it comes near."""
        if self._ball is None or self._ticks_lost > PATIENCE_TICKS:
            return self._enter("seen")
        bearing = self._pose.bearing_to(*self._ball)
        standing = self._standing_distance(robot)
        gap = self._pose.distance_to(*self._ball) - standing
        if not self._way.is_straight(self._pose, *self._ball, standing, is_surveyed=self._is_surveyed(robot)):
            return self._go_round(robot)
        if blob and abs(gap) < 0.02 and abs(bearing) < CENTRED_RAD:
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
        return STANDING if blob else self._enter("search")

    def _go_round(self, robot: Robot) -> Twist:
        """Plan a way round; where none is known, look round first, then from elsewhere; give up what does not show."""
        if self._ball is None or not self._is_sighted:
            self._ball = None
            return self._enter("search")
        nearest = self._standing_distance(robot) + 0.05
        if self._way.plan_to_ring(self._pose, *self._ball, nearest, nearest + 0.35):
            self._is_sighted = False
            return self._enter("avoid")
        if not self._is_surveyed(robot):
            self._surveyed_at = self._pose
            return self._enter("survey")
        self._is_sighted = False
        if self._way.plan_to_view(self._pose):
            return self._enter("avoid")
        self._way.forget()
        return self._enter("search")

    def _is_surveyed(self, robot: Robot) -> bool:
        """Return whether the robot has just looked all round, about where it is."""
        at = self._surveyed_at
        return at is not None and self._pose.distance_to(at.x, at.y) < robot.drive.reach

    def _enter(self, state: str) -> Twist:
        """Begin a state, standing."""
        self.state = state
        self._turned = 0.0
        self._ticks_here = 0
        return STANDING

    def _locate(self, robot: Robot) -> None:
        """Learn where the robot is and what is before it."""
        pose = robot.drive.pose
        self._turned += abs(wrap_angle(pose.heading - self._pose.heading))
        self._pose = pose
        self._ticks_here += 1
        self._way.observe(robot, pose)

    def _look(self, robot: Robot) -> Blob | None:
        """Return the largest patch of the hue, if there is one, and note where its ball lies."""
        frame = robot.camera.read()
        blobs = self._detector.find(frame.image, robot.camera.intrinsics)[:1]
        if robot.has(Role.DISPLAY):
            robot.display.show(marked(frame.image, blobs))
        if not blobs:
            self._ticks_lost += 1
            return None
        self._ticks_lost = 0
        if blobs[0].area >= SEEN_PX or self._ball is None:
            self._ball = self._place_of(blobs[0], robot)
            self._is_sighted = True
        return blobs[0]

    def _place_of(self, blob: Blob, robot: Robot) -> tuple[float, float]:
        """Return where the ball lies: by its size, and by its echo where that agrees."""
        eye = self._pose.moved(robot.camera.mount)
        away = self.ball_radius_m * robot.camera.intrinsics.focal_length / blob.radius
        echo = robot.range.read().distance + self.ball_radius_m
        if abs(blob.bearing) < robot.range.cone / 2 and (blob.is_clipped or abs(echo - away) < 0.15):
            away = echo
        return eye.to_world(away * math.cos(blob.bearing), away * math.sin(blob.bearing))

    def _standing_distance(self, robot: Robot) -> float:
        """From the axle to the ball's middle, when the robot stands where it means to."""
        return robot.range.mount.x + self.stop_distance_m + self.ball_radius_m


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("green-search")
