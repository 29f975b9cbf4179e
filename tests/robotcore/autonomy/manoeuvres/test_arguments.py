"""Arguments that a manoeuvre refuses when it is called, before anything moves."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore import Robot, Routine, arc, face, follow_path, go_to, move, sequence, straight, turn
from robotcore.errors import UnmetNeedError, UsageError
from robotcore.testing import MockRobot
from tests.texts import Raises

NAN, INF = float("nan"), float("inf")


def open_robot(name: str = "rover") -> Robot:
    return MockRobot(name).layered


@pytest.mark.parametrize("value", [NAN, INF, -INF, 101.0, "1", None, [1.0, 2.0], 10**400, True])
def test_a_distance_that_is_no_sensible_number_is_refused(value: float, raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", manoeuvre="straight", argument="distance"):
        straight(open_robot(), value)


@pytest.mark.parametrize("value", [NAN, INF, "90", True, 90.0, -45.0])
def test_an_angle_that_is_no_sensible_number_is_refused(value: float, raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", manoeuvre="turn", argument="angle"):
        turn(open_robot(), value)
    with raises(UsageError, "manoeuvre-argument", manoeuvre="arc", argument="angle"):
        arc(open_robot(), 0.5, value)


@pytest.mark.parametrize("value", [0.0, -0.5, NAN, INF, "1", True])
def test_a_radius_that_is_not_positive_is_refused(value: float, raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", manoeuvre="arc", argument="radius"):
        arc(open_robot(), value, 1.0)


@pytest.mark.parametrize("value", [0.0, -0.1, 0.4, NAN, "fast"])
def test_a_speed_that_the_drive_cannot_reach_is_refused(value: float, raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", argument="speed"):
        straight(open_robot(), 1.0, speed=value)
    with raises(UsageError, "manoeuvre-argument", argument="speed"):
        arc(open_robot(), 0.5, 1.0, speed=value)


def test_a_speed_at_which_the_outer_wheel_is_too_fast_is_refused(raises: Raises) -> None:
    straight(open_robot(), 1.0, speed=0.39).close()
    with raises(UsageError, "manoeuvre-argument", argument="speed"):
        arc(open_robot(), 0.2, 1.0, speed=0.39)


@pytest.mark.parametrize("value", [0.0, 5.1, NAN])
def test_a_turn_rate_that_the_drive_cannot_reach_is_refused(value: float, raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", argument="turn_rate"):
        turn(open_robot(), 1.0, turn_rate=value)


@pytest.mark.parametrize("value", [-1.0, NAN, INF, "1", True])
def test_a_time_that_is_no_sensible_number_is_refused(value: float, raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", manoeuvre="move", argument="seconds"):
        move(open_robot(), 0.1, seconds=value)


def test_a_robot_that_steers_cannot_turn(raises: Raises) -> None:
    with raises(UsageError, "cannot-turn-on-spot", manoeuvre="turn"):
        turn(open_robot("picar"), 1.0)


def test_an_arc_that_is_too_sharp_for_a_robot_that_steers_is_refused(raises: Raises) -> None:
    with raises(UsageError, "turn-too-sharp", radius_m=0.2):
        arc(open_robot("picar"), 0.2, 1.0)


MANOEUVRES: dict[str, Callable[[Robot], Routine[object]]] = {
    "straight": lambda robot: straight(robot, 1.0),
    "arc": lambda robot: arc(robot, 1.0, 1.0),
    "turn": lambda robot: turn(robot, 1.0),
    "go_to": lambda robot: go_to(robot, 1.0, 0.0),
    "follow_path": lambda robot: follow_path(robot, [(1.0, 0.0)]),
    "face": lambda robot: face(robot, 1.0),
    "move": lambda robot: move(robot, 0.1),
}


@pytest.mark.parametrize("name", MANOEUVRES)
def test_a_message_shows_the_public_name_of_a_manoeuvre(name: str) -> None:
    routine = MANOEUVRES[name](open_robot())
    routine.close()
    with pytest.raises(UsageError, match=f"^the routine {name} has already ended"):
        sequence(routine)


@pytest.mark.parametrize("build", [lambda r: straight(r, 1.0), lambda r: turn(r, 1.0), lambda r: arc(r, 1.0, 1.0)])
def test_a_robot_without_a_drive_is_refused(build: Callable[[Robot], object]) -> None:
    with pytest.raises(UnmetNeedError):
        build(open_robot("lookout"))
