"""Manoeuvres that begin at the present pose: straight, arc and turn."""

from __future__ import annotations

import math

from robotcore.autonomy.manoeuvres.limits import (
    MAX_M,
    build_path_profile,
    build_turn_profile,
    require_angle,
    require_number,
    require_positive,
    require_radius,
)
from robotcore.autonomy.manoeuvres.motion import Motion
from robotcore.autonomy.manoeuvres.path import Path, Piece
from robotcore.autonomy.manoeuvres.path_following import follow
from robotcore.autonomy.manoeuvres.speed_profile import SpeedProfile
from robotcore.autonomy.manoeuvres.spot_turn import turn_on_spot
from robotcore.autonomy.pending_routine import warn_if_dropped
from robotcore.autonomy.routines import Routine
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot


@warn_if_dropped
def straight(robot: Robot, distance: float, *, speed: float | None = None) -> Routine[Pose]:
    """Drive straight by a distance. The robot holds its heading, and stands at the end.

    distance: the distance in metres; negative to drive backward.
    speed: the greatest speed in m/s; by default half of what the drive can.

    Returns the pose at the end, in the frame of the odometry.

    Raises UsageError, when it is called, for a value that is not allowed; UnmetNeedError if the robot has no drive.
    The routine raises BlockedError if something blocks the robot.

    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     pose = robot.run(straight(robot, 0.5, speed=0.2))  # in an app: yield from straight(robot, 0.5)
    ...     round(pose.x, 2)
    0.5
    """
    distance = require_number("straight", "distance", distance, "metres", MAX_M)
    profile = build_path_profile("straight", robot.drive, speed)
    return _drive(robot, f"straight({distance:g})", distance, 0.0, profile)


@warn_if_dropped
def arc(robot: Robot, radius: float, angle: float, *, speed: float | None = None) -> Routine[Pose]:
    """Drive forward along an arc. The robot stands at the end.

    radius: the radius of the path of the axle's centre, in metres.
    angle: the angle by which the heading changes, in radians, positive to the left. The path has the length
        radius · abs(angle).
    speed: the greatest speed of the axle's centre in m/s; by default half of what the drive can on this arc.

    Returns the pose at the end, in the frame of the odometry.

    Raises UsageError, when it is called, for a value that is not allowed, such as a radius below
    ``robot.drive.min_turn_radius``; UnmetNeedError if the robot has no drive. The routine raises BlockedError if
    something blocks the robot.

    >>> import math
    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     pose = robot.run(arc(robot, radius=0.5, angle=math.pi / 2))  # a quarter of a circle to the left
    ...     round(pose.x, 2), round(pose.y, 2)
    (0.5, 0.5)
    """
    radius = require_radius("arc", robot.drive, require_positive("arc", "radius", radius, "metres", MAX_M))
    angle = require_angle("arc", "angle", angle)
    curvature = math.copysign(1 / radius, angle)
    profile = build_path_profile("arc", robot.drive, speed, curvature)
    name = f"arc({radius:g}, {angle:g})"
    return _drive(robot, name, radius * abs(angle), curvature, profile)


@warn_if_dropped
def turn(robot: Robot, angle: float, *, turn_rate: float | None = None) -> Routine[Pose]:
    """Turn on the spot by an angle. The robot stands at the end.

    angle: the angle in radians, positive to the left. It may be more than a whole turn, up to 20 rad.
    turn_rate: the greatest turn rate in rad/s; by default 0.3 of what the drive can.

    Returns the pose at the end, in the frame of the odometry. Its heading counts whole turns.

    Raises UsageError, when it is called, for a value that is not allowed, and for a robot that cannot turn on the spot;
    UnmetNeedError if the robot has no drive. The routine raises BlockedError if something blocks the robot.

    >>> import math
    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     pose = robot.run(turn(robot, math.pi / 2))
    ...     round(math.degrees(pose.heading))
    90
    """
    angle = require_angle("turn", "angle", angle)
    profile = build_turn_profile("turn", robot.drive, turn_rate)
    return _turn(robot, f"turn({angle:g})", angle, profile)


def _drive(robot: Robot, name: str, length: float, curvature: float, profile: SpeedProfile) -> Routine[Pose]:
    motion = Motion(robot, name)
    if length:
        yield from motion.prepare()
        yield from follow(motion, Path([Piece(motion.pose, length, curvature)]), profile)
    return motion.pose


def _turn(robot: Robot, name: str, angle: float, profile: SpeedProfile) -> Routine[Pose]:
    motion = Motion(robot, name)
    if angle:
        yield from motion.prepare()
        yield from turn_on_spot(motion, motion.pose.heading + angle, profile)
    return motion.pose
