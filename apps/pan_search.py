"""Search for a green ball with a camera on a servo, and drive to the ball around obstacles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from robotcore import Behaviour, Pose, Positive, Robot, Role, Status, Stopping, Truth, Twist
from robotcore.autonomy.navigation import BallTracker, Navigator, StopPoint
from robotcore.kinds import Servo

STANDING = Twist(0.0, 0.0)
ARRIVED_M, CENTRED_RAD = 0.03, 0.1
"""The robot has arrived if its distance from the stopping point and its angle to the ball are less than these."""
BALL_RADIUS_M = 0.10
"""The radius of the ball."""
AHEAD_RAD = 0.5
"""The greatest angle of a camera that drives forward, if the range sensor is on the same servo."""
LOST_AFTER_S = 0.5
"""A ball that no picture shows for this time is lost."""
STANDING_S = 0.5
"""The app succeeds after standing at the ball for this time."""


@dataclass
class PanSearch(Behaviour):
    """Pans the camera while the robot explores. Then it keeps the camera on the ball while the robot drives to it.

    If the servo also turns the range sensor, the servo points ahead while the robot drives forward.
    """

    hue: str = "green"
    """The ball's hue, by name or in degrees."""
    speed_m_s: Positive = 0.25
    """The greatest velocity forward."""
    turn_rad_s: Positive = 1.5
    """The greatest turn rate."""
    pan_rad_s: Positive = 1.5
    """The rate at which the camera pans while it searches."""
    stop_distance_m: Positive = 0.28
    """The distance between the range sensor and the ball when the robot stops."""

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE, "pan"})
    turns_on_spot = True
    milestones = ("look", "explore", "approach", "arrived")

    def __post_init__(self) -> None:
        self.state, self._now, self._moved_at, self._side = "look", 0.0, 0.0, 1.0
        self._ball, self._navigator = BallTracker(self.hue, BALL_RADIUS_M), Navigator(self.speed_m_s, self.turn_rad_s)

    @property
    def stopping(self) -> Stopping:
        return Stopping(self.stop_distance_m, self.speed_m_s)

    def verify(self, truth: Truth) -> bool:
        """Return whether the robot stands 0.15 to 0.40 m in front of the ball and the camera sees it."""
        distance = truth.distance_to_target
        return distance is not None and 0.15 <= distance <= 0.40 and truth.is_at_rest and truth.sees_target

    def step(self, robot: Robot) -> Status:
        pose, passed = robot.drive.pose, robot.clock.now() - self._now
        self._now += passed
        self._navigator.observe(robot, pose)
        self._ball.look(robot, pose)
        if self._ball.lost_for > LOST_AFTER_S and self.state in ("approach", "arrived"):
            self._ball.forget()
        place = self._ball.place
        twist = (self._drive_to_ball(robot, pose, *place) if place else self._explore(pose)) or STANDING
        self._pan(robot, pose, passed, is_driving=twist.linear > 0)
        robot.drive.set_velocity(*twist)
        self._moved_at = self._moved_at if self.state == "arrived" else self._now
        return Status.SUCCESS if self._now - self._moved_at > STANDING_S else Status.RUNNING

    def _pan(self, robot: Robot, pose: Pose, passed: float, *, is_driving: bool) -> None:
        """Turn the camera to the ball. Without a ball, turn it from one limit of the servo to the other and back."""
        pan, mount = cast("Servo", robot["pan"]), robot.camera.mount
        if self._ball.place:
            angle = mount.heading + pose.compose(mount).bearing_to(*self._ball.place)
        else:
            if pan.angle in (pan.min_angle, pan.max_angle):
                self._side = -1.0 if pan.angle == pan.max_angle else 1.0
            angle = pan.angle + self._side * self.pan_rad_s * passed
        if is_driving and robot.range.mount.heading == mount.heading:  # the range sensor is on the servo too
            angle = max(-AHEAD_RAD, min(angle, AHEAD_RAD))
        pan.set_angle(angle)

    def _explore(self, pose: Pose) -> Twist | None:
        """Turn until the camera has seen everything that is visible from here. Then drive to the next best view."""
        nav = self._navigator
        if twist := nav.follow(pose) if self.state == "explore" else nav.look(pose):
            return twist
        self.state = "explore" if self.state == "look" and nav.plan_to_view(pose) else "look"
        nav.begin_look(pose)
        return None

    def _drive_to_ball(self, robot: Robot, pose: Pose, x: float, y: float) -> Twist | None:
        """Drive straight to the ball, else around obstacles. Where the map is unknown, survey it by turning."""
        nav, front = self._navigator, robot.range.mount.x
        target = StopPoint(x, y, front + self.stop_distance_m + BALL_RADIUS_M)
        act = {"avoid": nav.follow, "survey": nav.survey}.get(self.state)
        if act and (twist := act(pose)):
            return twist
        if nav.is_straight(pose, target):
            is_ahead = abs(target.gap(pose)) < ARRIVED_M and abs(target.bearing(pose)) < CENTRED_RAD
            is_there = is_ahead and not self._ball.lost_for
            self.state = "arrived" if is_there else "approach"
            return None if is_there else nav.drive_at(pose, target)
        if nav.plan_to(pose, target):
            self.state = "avoid"
        elif nav.survey_more(pose):
            self.state = "survey"
        elif nav.plan_to_view(pose):
            self.state = "avoid"
        else:
            self._ball.forget()
            nav.forget(pose)
        return None


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("pan-search")
