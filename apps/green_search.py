"""Search for a green ball, drive to it around obstacles, and stop in front of it."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated

from robotcore import Behaviour, Interval, Positive, Robot, Role, Status, Stopping, Truth
from robotcore.autonomy.navigation import (
    FACING_RAD,
    BallTracker,
    Navigator,
    OccupancyGrid,
    StopPoint,
    drive_to,
    explore,
    turn_to,
)
from robotcore.autonomy.routines import Routine, race, until, wait
from robotcore.autonomy.vision import DEFAULT_TOLERANCE
from robotcore.errors import RoutineError

ECHO_M = 0.1
"""While the robot stands at the ball, the measured range differs from ``stop_distance_m`` by less than this."""

CONFIRM_S = 0.15
"""The robot stands for this time, three pictures at 20 Hz, before it turns to a blob. Reflections vanish sooner."""

PATIENCE_S = 0.5
"""A ball that no picture shows for this time is gone, if nothing hides it. Standing at it for this time is success."""

REST_S, REST_M, REST_RAD = 0.15, 0.001, 0.005
"""The robot is at rest if it has moved and turned by less than this in this time.

After a stop command, the wheels turn for a moment.
"""


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

    @property
    def stopping(self) -> Stopping:
        return Stopping(self.stop_distance_m, self.speed_m_s)

    @property
    def grid(self) -> OccupancyGrid:
        """The map of the search. The live page shows it."""
        return self._navigator.map.grid

    def verify(self, truth: Truth) -> bool:
        """Return whether the robot stands 0.15 to 0.40 m in front of the ball and sees it."""
        distance = truth.distance_to_target
        is_near = distance is not None and 0.15 <= distance <= 0.40
        return is_near and truth.is_at_rest and truth.sees_target

    def run(self, robot: Robot) -> Routine[Status]:
        """Track the ball in each tick, and meanwhile search for it and drive to it."""
        yield from race(self._ball.watch(robot), self._reach_ball(robot))
        return Status.SUCCESS

    def _reach_ball(self, robot: Robot) -> Routine[None]:
        """Search and drive again and again, until the robot stands in front of the ball."""
        has_arrived = False
        while not has_arrived:
            self._ball.forget()
            with suppress(RoutineError):  # something blocked the robot, or there is no path to the ball
                has_arrived = yield from self._attempt(robot)

    def _attempt(self, robot: Robot) -> Routine[bool]:
        """Search for the ball, drive to it, and stand there. Return False if the ball is not there."""
        self.state = "search"
        yield from until(lambda: self._ball.is_in_sight, explore(robot, self._navigator))
        self.state = "seen"
        robot.drive.stop()
        yield from wait(robot, CONFIRM_S)
        if self._ball.lost_for:
            return False
        yield from turn_to(robot, self._navigator, lambda: self._build_target(robot))
        self.state = "approach"
        driving = drive_to(robot, self._navigator, lambda: self._build_target(robot))
        if (yield from until(lambda: self._is_gone(robot), driving)) or not self._is_at_ball(robot):
            return False
        self.state = "arrived"
        return not (yield from until(lambda: not self._is_at_ball(robot), self._stand(robot)))

    def _stand(self, robot: Robot) -> Routine[None]:
        """Stand for `PATIENCE_S`, and until the robot is at rest."""
        yield from wait(robot, PATIENCE_S - REST_S)
        is_at_rest = False
        while not is_at_rest:
            x, y, heading = robot.drive.pose
            yield from wait(robot, REST_S)
            pose = robot.drive.pose
            is_at_rest = pose.distance_to(x, y) < REST_M and abs(pose.heading - heading) < REST_RAD

    def _build_target(self, robot: Robot) -> StopPoint:
        """Return the ball's position, with the distance from its centre at which the robot's axle must stop."""
        assert self._ball.place, "the state search ends when the ball's position is known"
        return StopPoint(*self._ball.place, robot.range.mount.x + self.stop_distance_m + self.ball_radius_m)

    def _is_gone(self, robot: Robot) -> bool:
        """Return whether no picture shows the ball, although the robot faces it and no obstacle hides it."""
        pose, target = robot.drive.pose, self._build_target(robot)
        is_lost = self._ball.lost_for > PATIENCE_S and abs(target.bearing(pose)) < FACING_RAD
        return is_lost and self._navigator.is_known_straight(pose, target)

    def _is_at_ball(self, robot: Robot) -> bool:
        """Return whether both the camera and the range sensor detect the ball in front of the robot."""
        return not self._ball.lost_for and abs(robot.range.read().distance - self.stop_distance_m) < ECHO_M


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("green-search")
