"""The drive of a live robot. A call of a manoeuvre returns when the robot has arrived."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

from robotcore.autonomy.manoeuvres import arc, face, follow_path, go_to, move, straight, turn
from robotcore.autonomy.routines import Routine
from robotcore.errors import UsageError
from robotcore.geometry import Pose, Twist, Wheels
from robotcore.hal.drive import DifferentialDrive
from robotcore.hal.robot import Robot
from robotcore.interactive.attribute_errors import raise_attribute_error

__all__ = ["LiveDrive"]


class LiveDrive(DifferentialDrive):
    """Drives a live robot. A manoeuvre lets time pass until the robot stands, and returns its pose by the odometry.

    A manoeuvre raises BlockedError if something blocks the robot, and UsageError for a wrong argument.

    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     pose = robot.drive.straight(0.5)
    ...     print(f"{pose.x:.2f} m")
    0.50 m

    drive: the drive of the app's robot.
    robot: the live robot.
    run: runs a routine to its end, and returns its result.
    is_running: returns whether a routine runs.
    """

    def __init__(
        self,
        drive: DifferentialDrive,
        robot: Robot,
        run: Callable[[Routine[Any]], Any],
        is_running: Callable[[], bool],
    ) -> None:
        vars(self).update(vars(drive))
        self._robot, self._run, self._is_running = robot, run, is_running

    if not TYPE_CHECKING:  # a type checker finds unknown attributes itself

        def __getattr__(self, name: str) -> NoReturn:
            raise_attribute_error(name, {"robot.drive": self})

    def straight(self, distance: float, *, speed: float | None = None) -> Pose:
        """Drive straight by a distance in metres; negative to drive backward. See `robotcore.straight`."""
        pose: Pose = self._run(straight(self._robot, distance, speed=speed))
        return pose

    def turn(self, angle: float, *, turn_rate: float | None = None) -> Pose:
        """Turn on the spot by an angle in radians, positive to the left. See `robotcore.turn`."""
        pose: Pose = self._run(turn(self._robot, angle, turn_rate=turn_rate))
        return pose

    def arc(self, radius: float, angle: float, *, speed: float | None = None) -> Pose:
        """Drive along an arc. See `robotcore.arc`.

        radius: the radius in metres.
        angle: the angle in radians, positive to the left.
        """
        pose: Pose = self._run(arc(self._robot, radius, angle, speed=speed))
        return pose

    def go_to(self, x: float, y: float, *, speed: float | None = None, turn_rate: float | None = None) -> Pose:
        """Drive to a point in metres, in the frame of the odometry. See `robotcore.go_to`."""
        pose: Pose = self._run(go_to(self._robot, x, y, speed=speed, turn_rate=turn_rate))
        return pose

    def follow_path(
        self, points: Sequence[tuple[float, float]], *, speed: float | None = None, turn_rate: float | None = None
    ) -> Pose:
        """Drive through points, each x and y in metres, in the frame of the odometry. See `robotcore.follow_path`."""
        pose: Pose = self._run(follow_path(self._robot, points, speed=speed, turn_rate=turn_rate))
        return pose

    def face(self, heading: float, *, turn_rate: float | None = None) -> Pose:
        """Turn on the spot to a heading in radians, in the frame of the odometry. See `robotcore.face`."""
        pose: Pose = self._run(face(self._robot, heading, turn_rate=turn_rate))
        return pose

    def move(self, linear: float, angular: float = 0.0, *, seconds: float) -> None:
        """Drive at a velocity for a time. See `robotcore.move`.

        linear: the velocity in m/s.
        angular: the turn rate in rad/s, positive to the left.
        seconds: the time in seconds.
        """
        self._run(move(self._robot, linear, angular, seconds=seconds))

    def set_velocity(self, linear: float, angular: float) -> Twist:
        """Set the velocity for this tick, within a routine. Raises UsageError between two calls."""
        self._require_routine("move(linear, angular, seconds=1.0)")
        return super().set_velocity(linear, angular)

    def set_wheels(self, left: float, right: float) -> Wheels:
        """Set the velocities of the wheels for this tick, within a routine. Raises UsageError between two calls."""
        self._require_routine("move(linear, angular, seconds=1.0)")
        return super().set_wheels(left, right)

    def _require_routine(self, remedy: str) -> None:
        if not self._is_running():
            raise UsageError(
                "no time passes between two calls of a live robot, so a velocity has no effect. "
                f"Write robot.drive.{remedy}, or set the velocity in a generator: robot.run(my_routine(robot))",
                kind="velocity-without-time",
            )
