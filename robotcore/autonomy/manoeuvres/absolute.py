"""Manoeuvres to places and directions in the frame of the odometry: go_to, follow_path and face."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain, pairwise

from robotcore.autonomy.manoeuvres.limits import (
    MAX_M,
    MAX_RAD,
    build_path_profile,
    build_turn_profile,
    require_angle,
    require_number,
)
from robotcore.autonomy.manoeuvres.motion import Motion
from robotcore.autonomy.manoeuvres.path_following import follow
from robotcore.autonomy.manoeuvres.path_planning import Point, plan_path, split_at_turns
from robotcore.autonomy.manoeuvres.speed_profile import SpeedProfile
from robotcore.autonomy.manoeuvres.spot_turn import turn_on_spot
from robotcore.autonomy.pending_routine import warn_if_dropped
from robotcore.autonomy.routines import Routine
from robotcore.errors import UsageError
from robotcore.geometry import Pose, wrap_angle
from robotcore.hal.robot import Robot
from robotcore.text import pluralize


@warn_if_dropped
def go_to(
    robot: Robot, x: float, y: float, *, speed: float | None = None, turn_rate: float | None = None
) -> Routine[Pose]:
    """Drive to a point: turn to it on the spot, then drive straight. A robot that steers drives an arc and a line.

    x, y: the point in metres, in the frame of the odometry: the robot was opened at (0, 0), with the heading 0.
    speed: the greatest speed in m/s; by default half of what the drive can.
    turn_rate: the greatest turn rate on the spot in rad/s; by default 0.3 of what the drive can.

    Returns the pose at the end, in the same frame. Its heading is the direction of the last line.

    Raises UsageError, when it is called, for a value that is not allowed, and for a point inside of the turning circle
    of a robot that steers; UnmetNeedError if the robot has no drive. The routine raises BlockedError if something
    blocks the robot, and UsageError if the robot has moved since the call, so that the point is too near now.

    >>> import math
    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     pose = robot.run(go_to(robot, 0.3, 0.3))
    ...     round(pose.x, 2), round(pose.y, 2), round(math.degrees(pose.heading))
    (0.3, 0.3, 45)
    """
    point = (require_number("go_to", "x", x, "metres", MAX_M), require_number("go_to", "y", y, "metres", MAX_M))
    return _build_routine(robot, "go_to", f"go_to({point[0]:g}, {point[1]:g})", [point], speed, turn_rate)


@warn_if_dropped
def follow_path(
    robot: Robot, points: Sequence[Point], *, speed: float | None = None, turn_rate: float | None = None
) -> Routine[Pose]:
    """Drive through points to the last one.

    The robot rounds a corner if its path then passes within 1 cm of the point. Otherwise it stops there, and turns on
    the spot. A robot that steers rounds each corner with an arc of 1.1 times its smallest radius.

    points: the points, each x and y in metres, in the frame of `go_to`.
    speed, turn_rate: as for `go_to`.

    Returns the pose at the end, in the same frame.

    Raises the same errors as `go_to`, and UsageError for a path without points, or with a corner that is too sharp for
    a robot that steers.

    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     pose = robot.run(follow_path(robot, [(0.4, 0.0), (0.4, 0.4)]))
    ...     round(pose.x, 2), round(pose.y, 2)
    (0.4, 0.4)
    """
    places = _require_points(points)
    name = f"follow_path through {pluralize(len(places), 'point')}"
    return _build_routine(robot, "follow_path", name, places, speed, turn_rate)


@warn_if_dropped
def face(robot: Robot, heading: float, *, turn_rate: float | None = None) -> Routine[Pose]:
    """Turn on the spot to a heading, the shorter way.

    heading: the heading in radians, in the frame of `go_to`: 0 is the direction in which the robot was opened, and
        positive angles are to the left of it. To face a blob of a camera, use `turn` with its bearing.
    turn_rate: the greatest turn rate in rad/s; by default 0.3 of what the drive can.

    Returns the pose at the end, in the same frame.

    Raises the same errors as `turn`.

    >>> from robotcore import turn
    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(turn(robot, 2.0)).heading > 1.9
    ...     pose = robot.run(face(robot, 0.0))  # the direction in which it was opened
    ...     abs(pose.heading) < 0.02
    True
    True
    """
    counted = abs(robot.drive.pose.heading)  # the heading of the odometry counts whole turns
    heading = require_angle("face", "heading", heading, MAX_RAD + counted)
    profile = build_turn_profile("face", robot.drive, turn_rate)
    return _face(robot, f"face({heading:g})", heading, profile)


def _build_routine(
    robot: Robot, manoeuvre: str, name: str, points: Sequence[Point], speed: float | None, turn_rate: float | None
) -> Routine[Pose]:
    drive = robot.drive
    profile = build_path_profile(manoeuvre, drive, speed)
    turn_profile = None if drive.min_turn_radius else build_turn_profile(manoeuvre, drive, turn_rate)
    for group in split_at_turns(drive.pose[:2], points, drive):
        plan_path(drive.pose, group, drive)  # raises the errors before anything moves
    return _drive_through(robot, name, points, profile, turn_profile)


def _drive_through(
    robot: Robot, name: str, points: Sequence[Point], profile: SpeedProfile, turn_profile: SpeedProfile | None
) -> Routine[Pose]:
    motion = Motion(robot, name)
    groups = split_at_turns(motion.pose[:2], points, robot.drive)
    for index, group in enumerate(groups):
        yield from motion.prepare()
        if turn_profile:
            yield from turn_on_spot(motion, motion.pose.heading + motion.pose.bearing_to(*group[0]), turn_profile)
            motion = Motion(robot, name)
        path = plan_path(motion.pose, group, robot.drive)
        limited = profile.limit_to(path.curvature * motion.half_track, robot.drive.max_linear)
        places_after = [group[-1], *chain.from_iterable(groups[index + 1 :])]
        yield from follow(motion, path, limited, sum(math.dist(*pair) for pair in pairwise(places_after)))
        motion = Motion(robot, name)
    return motion.pose


def _face(robot: Robot, name: str, heading: float, profile: SpeedProfile) -> Routine[Pose]:
    motion = Motion(robot, name)
    yield from motion.prepare()
    yield from turn_on_spot(motion, motion.pose.heading + wrap_angle(heading - motion.pose.heading), profile)
    return motion.pose


def _require_points(points: Sequence[Point]) -> list[Point]:
    try:
        pairs = [(x, y) for x, y in points]
    except (TypeError, ValueError):
        pairs = []
    if not pairs or isinstance(points, str):
        raise UsageError(
            f"points of follow_path is {points!r:.50}. Give a list of points, each a pair of x and y in metres, such "
            "as [(1.0, 0.0), (1.0, 0.5)]",
            kind="manoeuvre-argument",
            manoeuvre="follow_path",
            argument="points",
        )
    return [
        (require_number("follow_path", "x", x, "metres", MAX_M), require_number("follow_path", "y", y, "metres", MAX_M))
        for x, y in pairs
    ]
