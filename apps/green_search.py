"""Search for a green ball, drive to it around obstacles, and stop in front of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from robotcore import Behaviour, Interval, Pose, Positive, Robot, Role, Status, Stopping, Truth, Twist
from robotcore.autonomy.navigation import BallTracker, Navigator, StopPoint
from robotcore.autonomy.vision import DEFAULT_TOLERANCE, Blob

STANDING = Twist(0.0, 0.0)
CENTRED_RAD = 0.1
"""The robot faces the ball if the magnitude of the ball's bearing is at most this."""

NEAR_M, TOO_NEAR_M = 0.02, 0.06
"""The robot has arrived if it is less than `NEAR_M` short of its stopping point, or less than `TOO_NEAR_M` past it."""

ECHO_M = 0.1
"""While the robot stands at the ball, the measured range differs from ``stop_distance_m`` by less than this."""

CONFIRM_S = 0.15
"""The robot faces a blob for this time, three pictures at 20 Hz, before it drives to it. Reflections vanish sooner."""

PATIENCE_S = 0.5
"""A ball that no picture shows for this time is lost. The app succeeds after standing at the ball for this time."""


@dataclass
class GreenSearch(Behaviour):
    """Turns and explores until it sees the ball, drives to it, and stops in front of it."""

    hue: str = "green"
    """The ball's hue, by name or in degrees."""
    speed_m_s: Positive = 0.25
    """The greatest velocity forward."""
    turn_rad_s: Positive = 1.5
    """The greatest turn rate."""
    stop_distance_m: Positive = 0.28
    """The distance between the range sensor and the ball when the robot stops."""
    ball_radius_m: Positive = 0.10
    """The ball's radius."""
    tolerance: Annotated[float, Interval(gt=0, lt=90)] = DEFAULT_TOLERANCE
    """Half the accepted range around ``hue``, in degrees. The range of a name ends where that of the next begins."""

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})
    wants = frozenset({Role.DISPLAY})
    turns_on_spot = True
    milestones = ("search", "seen", "approach", "arrived")

    def __post_init__(self) -> None:
        self._ball = BallTracker(self.hue, self.ball_radius_m, self.tolerance)
        self._navigator = Navigator(self.speed_m_s, self.turn_rad_s)
        self._pose = Pose(0.0, 0.0, 0.0)
        self._now = 0.0
        self._command = STANDING
        self._begin_search()

    @property
    def stopping(self) -> Stopping:
        return Stopping(self.stop_distance_m, self.speed_m_s)

    def verify(self, truth: Truth) -> bool:
        """Return whether the robot stands 0.15 to 0.40 m in front of the ball and sees it."""
        distance = truth.distance_to_target
        is_near = distance is not None and 0.15 <= distance <= 0.40
        return is_near and truth.is_at_rest and truth.sees_target

    def step(self, robot: Robot) -> Status:
        self._pose, self._now = robot.drive.pose, robot.clock.now()
        self._navigator.observe(robot, self._pose)
        blob = self._ball.look(robot, self._pose)
        if self._navigator.is_blocked(robot, self._pose, self._command):
            self._ball.forget()
            self._enter_and_stand("retreat")
        act = {
            "retreat": self._retreat,
            "search": self._search,
            "explore": self._explore,
            "seen": self._confirm,
            "approach": self._approach,
            "avoid": self._avoid,
            "survey": self._survey,
            "arrived": self._stand,
        }[self.state]
        self._command = act(robot, blob)
        robot.drive.set_velocity(*self._command)
        is_done = self.state == "arrived" and self._seconds_in_state > PATIENCE_S
        return Status.SUCCESS if is_done else Status.RUNNING

    def _retreat(self, robot: Robot, blob: Blob | None) -> Twist:
        """Drive away from an obstacle that blocks the robot. Then search again, because the map was wrong."""
        return self._navigator.retreat(self._pose) or self._begin_search()

    def _search(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn until the camera has seen everything that is visible from here. Then drive to the next best view."""
        if self._ball.is_in_sight:
            return self._enter_and_stand("seen")
        if twist := self._navigator.look(self._pose):
            return twist
        if self._navigator.plan_to_view(self._pose):
            return self._enter_and_stand("explore")
        self._navigator.forget(self._pose)
        return self._begin_search()

    def _explore(self, robot: Robot, blob: Blob | None) -> Twist:
        if self._ball.is_in_sight:
            return self._enter_and_stand("seen")
        return self._navigator.follow(self._pose) or self._begin_search()

    def _confirm(self, robot: Robot, blob: Blob | None) -> Twist:
        """Face the ball until it is confirmed. If an obstacle hides the ball, drive around the obstacle."""
        target = self._build_target(robot)
        bearing = blob.bearing if blob else target.bearing(self._pose)
        if abs(bearing) > CENTRED_RAD or self._seconds_in_state < CONFIRM_S:
            return self._navigator.turn_to(bearing)
        if blob:
            return self._enter_and_stand("approach")
        if self._ball.lost_for < PATIENCE_S:
            return STANDING
        is_gone = self._navigator.is_known_straight(self._pose, target)
        return self._restart_search() if is_gone else self._drive_around(target)

    def _approach(self, robot: Robot, blob: Blob | None) -> Twist:
        target = self._build_target(robot)
        if self._ball.lost_for > PATIENCE_S:
            return self._enter_and_stand("seen")
        if not self._navigator.is_straight(self._pose, target):
            return self._drive_around(target)
        is_there = -TOO_NEAR_M < target.gap(self._pose) < NEAR_M
        if blob and is_there and abs(target.bearing(self._pose)) < CENTRED_RAD:
            return self._enter_and_stand("arrived")
        return self._navigator.drive_at(self._pose, target) or self._drive_around(target)

    def _avoid(self, robot: Robot, blob: Blob | None) -> Twist:
        """Follow the planned path through free cells. If it continues through unknown cells, survey them."""
        if twist := self._navigator.follow(self._pose):
            return twist
        if not self._navigator.is_at_frontier:
            return self._enter_and_stand("seen")
        self._navigator.survey_ahead(self._pose)
        return self._enter_and_stand("survey")

    def _survey(self, robot: Robot, blob: Blob | None) -> Twist:
        """Turn to both sides, so that the range sensor measures the surroundings. Then plan the path again."""
        return self._navigator.survey(self._pose) or self._drive_around(self._build_target(robot))

    def _stand(self, robot: Robot, blob: Blob | None) -> Twist:
        """Stand still while both the camera and the range sensor detect the ball, else search again."""
        is_there = abs(robot.range.read().distance - self.stop_distance_m) < ECHO_M
        return STANDING if blob and is_there else self._begin_search()

    def _drive_around(self, target: StopPoint) -> Twist:
        """Plan a path around an obstacle. If there is none, survey, else drive to another view, else search again."""
        if self._navigator.plan_to(self._pose, target):
            return self._enter_and_stand("avoid")
        if self._navigator.survey_more(self._pose):
            return self._enter_and_stand("survey")
        if self._navigator.plan_to_view(self._pose):
            return self._enter_and_stand("avoid")
        self._navigator.forget(self._pose)
        return self._restart_search()

    def _restart_search(self) -> Twist:
        self._ball.forget()
        return self._begin_search()

    def _begin_search(self) -> Twist:
        self._navigator.begin_look(self._pose)
        return self._enter_and_stand("search")

    def _enter_and_stand(self, state: str) -> Twist:
        self.state = state
        self._entered_at = self._now
        return STANDING

    @property
    def _seconds_in_state(self) -> float:
        return self._now - self._entered_at

    def _build_target(self, robot: Robot) -> StopPoint:
        """Return the ball's position, with the distance from its centre at which the robot's axle must stop."""
        assert self._ball.place, "only the states search and explore are possible before the ball is seen"
        return StopPoint(*self._ball.place, robot.range.mount.x + self.stop_distance_m + self.ball_radius_m)


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("green-search")
