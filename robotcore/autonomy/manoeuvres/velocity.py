"""The manoeuvre move: a velocity for a time."""

from __future__ import annotations

import math
from contextlib import suppress

from robotcore.autonomy.manoeuvres.limits import require_number
from robotcore.autonomy.pending_routine import warn_if_dropped
from robotcore.autonomy.routines import TIME_TOLERANCE_S, Routine
from robotcore.errors import RobotcoreError
from robotcore.hal.drive import DifferentialDrive
from robotcore.hal.robot import Robot

MAX_VELOCITY = 1000.0
"""The greatest velocity of an argument, in m/s or rad/s. The drive's own limit is lower."""

MAX_S = 1e6
"""The longest time of an argument, in seconds."""


@warn_if_dropped
def move(robot: Robot, linear: float, angular: float = 0.0, *, seconds: float | None = None) -> Routine[None]:
    """Drive at a velocity for a time. The safety stage limits the velocity, and the robot need not arrive anywhere.

    linear: the velocity forward in m/s.
    angular: the turn rate in rad/s, positive to the left.
    seconds: the time in seconds; None to drive until the routine is closed, as in ``until(condition, move(...))``.

    Raises UsageError, when it is called, for a value that is no finite number, and for a negative time;
    UnmetNeedError if the robot has no drive.

    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(move(robot, 0.2, seconds=1.0))
    ...     robot.clock.now(), round(robot.drive.pose.x, 1)
    (1.0, 0.2)
    """
    linear = require_number("move", "linear", linear, "m/s", MAX_VELOCITY)
    angular = require_number("move", "angular", angular, "rad/s", MAX_VELOCITY)
    time = math.inf if seconds is None else require_number("move", "seconds", seconds, "seconds", MAX_S, least=0.0)
    return _move(robot, robot.drive, linear, angular, time)


def _move(robot: Robot, drive: DifferentialDrive, linear: float, angular: float, seconds: float) -> Routine[None]:
    deadline = robot.clock.now() + seconds - TIME_TOLERANCE_S
    try:
        while robot.clock.now() < deadline:
            drive.set_velocity(linear, angular)
            yield
    finally:
        with suppress(RobotcoreError):  # the robot may be closed
            drive.set_velocity(0.0, 0.0)
