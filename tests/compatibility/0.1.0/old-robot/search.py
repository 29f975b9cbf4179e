"""Turn until the camera sees the ball, drive to it, and stop in front of it."""

from dataclasses import dataclass
from math import tau
from typing import Annotated

from robotcore import Behaviour, Interval, Robot, Role, Status, Stopping, Truth
from robotcore.autonomy.vision import Blob, ColourDetector

AHEAD_RAD = 0.2
"""The robot drives forward if the ball's bearing is smaller. The range sensor then measures the ball."""

STANDING_S = 0.5
"""The app succeeds after the robot has stood in front of the ball for this time, in seconds."""


@dataclass
class Search(Behaviour):
    """An app that finds a ball. Its fields are its settings: ``robotcore run search.py --set hue=blue``."""

    hue: str = "green"
    speed_m_s: Annotated[float, Interval(gt=0, le=0.3)] = 0.2
    turn_rad_s: Annotated[float, Interval(gt=0, le=2.0)] = 1.0
    stop_distance_m: Annotated[float, Interval(ge=0.2, le=0.35)] = 0.28

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})
    turns_on_spot = True
    milestones = ("search", "approach", "arrived")

    def __post_init__(self) -> None:
        self._detector = ColourDetector(self.hue)
        self._began_at_rad = 0.0
        self._arrived_at_s = 0.0

    def step(self, robot: Robot) -> Status:
        """Command the wheels for one tick."""
        if self.state == "arrived":
            return self._stand(robot)
        frame = robot.camera.read()
        seen = self._detector.find(frame.image, robot.camera.intrinsics)
        return self._approach(robot, seen[0]) if seen else self._search(robot)

    def _search(self, robot: Robot) -> Status:
        """Turn left on the spot. Fail after one full turn."""
        heading = robot.drive.pose.heading
        if self.state != "search":
            self.state, self._began_at_rad = "search", heading
        robot.drive.set_velocity(0.0, self.turn_rad_s)
        if heading - self._began_at_rad < tau:
            return Status.RUNNING
        self.reason = f"saw nothing {self.hue} in a full turn"
        return Status.FAILURE

    def _approach(self, robot: Robot, ball: Blob) -> Status:
        """Turn to the ball, drive to it, and stop near it."""
        self.state = "approach"
        is_ahead = abs(ball.bearing) < AHEAD_RAD
        if is_ahead and robot.range.read().distance < self.stop_distance_m:
            self.state, self._arrived_at_s = "arrived", robot.clock.now()
            return self._stand(robot)
        ahead_m_s = self.speed_m_s if is_ahead else 0.0
        robot.drive.set_velocity(ahead_m_s, 2 * ball.bearing)
        return Status.RUNNING

    def _stand(self, robot: Robot) -> Status:
        """Stand still for `STANDING_S` seconds, because a moving robot has not arrived."""
        robot.drive.stop()
        stood_s = robot.clock.now() - self._arrived_at_s
        return Status.SUCCESS if stood_s > STANDING_S else Status.RUNNING

    @property
    def stopping(self) -> Stopping:
        """The distance and the speed at which this app stops. The range guard of the robot must not stop it earlier."""
        return Stopping(self.stop_distance_m, self.speed_m_s)

    def verify(self, truth: Truth) -> bool:
        """Return whether the robot stands near the ball, sees it, and has touched nothing."""
        distance = truth.distance_to_target
        is_near = distance is not None and 0.15 <= distance <= 0.40
        is_clean = truth.is_at_rest and not truth.contacts
        return is_near and is_clean and truth.sees_target
