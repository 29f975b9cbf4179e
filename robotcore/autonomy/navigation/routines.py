"""Routines that drive a robot with a navigator: explore unknown surroundings, and drive to a target."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

from robotcore.autonomy.navigation.navigator import Navigator
from robotcore.autonomy.navigation.planner import StopPoint
from robotcore.autonomy.pending_routine import warn_if_dropped
from robotcore.autonomy.routines import Routine
from robotcore.errors import RoutineError, UsageError
from robotcore.geometry import Pose, Twist, to_number
from robotcore.hal.robot import Robot

Target: TypeAlias = StopPoint | Callable[[], StopPoint]
"""A target, or a function that returns the present target of each tick."""

STANDING = Twist(0.0, 0.0)

FACING_RAD = 0.1
"""The robot faces a target if the magnitude of the target's bearing is less than this."""

NEAR_M, TOO_NEAR_M = 0.02, 0.06
"""The robot has arrived if it is less than `NEAR_M` short of its stopping point, or less than `TOO_NEAR_M` past it."""


@warn_if_dropped
def explore(robot: Robot, navigator: Navigator) -> Routine[None]:
    """Turn until the camera has seen everything that is visible from here, drive to the next best view, and repeat.

    It does not end. Run it with `until`. If no view is left, it deletes the map, and begins again.

    Raises RoutineError if something blocks the robot, see `drive_to`.

    robot: a robot with drive, range sensor and camera.
    navigator: the map and the velocities.

    >>> import robotcore
    >>> from robotcore import Navigator, until
    >>> with robotcore.open("rover", world="arena") as robot:
    ...     exploration = explore(robot, Navigator(speed=0.2, turn=1.5))
    ...     robot.run(until(lambda: robot.clock.now() >= 1.0, exploration))
    ...     robot.drive.pose.heading != 0.0  # it looks around first
    True
    True
    """
    navigator.begin_look(robot.drive.pose)
    while True:
        yield from _move(robot, navigator, navigator.look)
        if navigator.plan_to_view(robot.drive.pose):
            yield  # the robot stands for a tick between two motions
            yield from _move(robot, navigator, navigator.follow)
        else:
            navigator.forget(robot.drive.pose)
        navigator.begin_look(robot.drive.pose)
        yield


@warn_if_dropped
def turn_to(robot: Robot, navigator: Navigator, target: Target) -> Routine[None]:
    """Turn on the spot until the robot faces a target. The errors are those of `drive_to`.

    robot, navigator, target: as for `drive_to`.

    >>> import robotcore
    >>> from robotcore import Navigator
    >>> from robotcore.autonomy.navigation import StopPoint
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(turn_to(robot, Navigator(speed=0.2, turn=1.5), StopPoint(x=0.0, y=1.0, distance=0.3)))
    ...     robot.drive.pose.heading > 1.4  # to the left
    True
    """

    def turn(pose: Pose) -> Twist | None:
        bearing = _locate(target).bearing(pose)
        return navigator.turn_to(bearing) if abs(bearing) >= FACING_RAD else None

    return _move(robot, navigator, turn)


@warn_if_dropped
def drive_to(robot: Robot, navigator: Navigator, target: Target) -> Routine[None]:
    """Drive to a target, stop in front of it and face it. Drive around obstacles, and map the surroundings meanwhile.

    If the known surroundings contain no path, the robot turns to measure more of them, and drives to other views.

    robot: a robot with drive, range sensor and camera.
    navigator: the map and the velocities.
    target: the target, or a function that returns it. The function is called in each tick, so the target may move.

    Raises UsageError if the target is no StopPoint of finite numbers.
    Raises RoutineError of the kind ``no-path`` if there is no path, and of the kind ``blocked`` if something blocks the
    robot. Then the robot has driven a little away from it. In both cases the map may be wrong, and the navigator has
    begun a new one.

    >>> import robotcore
    >>> from robotcore import Navigator
    >>> from robotcore.autonomy.navigation import StopPoint
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(drive_to(robot, Navigator(speed=0.2, turn=1.5), StopPoint(x=0.8, y=0.0, distance=0.3)))
    ...     0.4 < robot.drive.pose.x < 0.6
    True
    """

    def approach(pose: Pose) -> Twist | None:
        goal = _locate(target)
        is_end = _is_reached(goal, pose) or not navigator.is_straight(pose, goal)
        return None if is_end else navigator.drive_at(pose, goal)

    while True:
        yield from turn_to(robot, navigator, target)
        yield
        yield from _move(robot, navigator, approach)
        if _is_reached(_locate(target), robot.drive.pose):
            return
        yield from _drive_around(robot, navigator, target)
        yield


def _drive_around(robot: Robot, navigator: Navigator, target: Target) -> Routine[None]:
    """Drive to where a straight path may lead to a target, else to another view. Survey the surroundings for a path."""
    while (has_path := navigator.plan_to(robot.drive.pose, _locate(target))) or navigator.survey_more(robot.drive.pose):
        yield
        if has_path:
            yield from _move(robot, navigator, navigator.follow)
            if not navigator.is_at_frontier:
                return
            navigator.survey_ahead(robot.drive.pose)
            yield
        yield from _move(robot, navigator, navigator.survey)
    if not navigator.plan_to_view(robot.drive.pose):
        navigator.forget(robot.drive.pose)
        x, y, _ = _locate(target)
        text = f"the map has no path to x={x:.2f} m, y={y:.2f} m, and no view from which to look for one"
        raise RoutineError(f"{text}. Check whether obstacles surround the point or the robot", kind="no-path", x=x, y=y)
    yield
    yield from _move(robot, navigator, navigator.follow)


def _locate(target: Target) -> StopPoint:
    """Return the target of this tick. Raises UsageError if it is no StopPoint of finite numbers."""
    point: object = target() if callable(target) else target
    if not isinstance(point, StopPoint) or not all(map(math.isfinite, map(to_number, point))):
        text = (
            f"the target is {point!r:.100}. Give StopPoint(x, y, distance), or a function that returns one, in metres"
        )
        raise UsageError(text, kind="not-a-stop-point")
    return point


def _is_reached(target: StopPoint, pose: Pose) -> bool:
    return -TOO_NEAR_M < target.gap(pose) < NEAR_M and abs(target.bearing(pose)) < FACING_RAD


def _move(robot: Robot, navigator: Navigator, compute_velocity: Callable[[Pose], Twist | None]) -> Routine[None]:
    """Drive at the velocity for each tick until there is none, and map the surroundings in each tick.

    If something blocks the robot, drive a little away from it, and raise RoutineError.
    """
    velocity: Twist | None = STANDING
    while velocity:
        pose = robot.drive.pose
        navigator.observe(robot, pose)
        if navigator.is_blocked(robot, pose, velocity):
            yield from _move(robot, navigator, navigator.retreat)
            text = f"something blocked the robot at x={pose.x:.2f} m, y={pose.y:.2f} m. Drive another way"
            raise RoutineError(text, kind="blocked", x=pose.x, y=pose.y)
        velocity = compute_velocity(pose)
        robot.drive.set_velocity(*velocity or STANDING)
        if velocity:
            yield
