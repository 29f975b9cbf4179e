"""Contacts of the body with the things of a world."""

from __future__ import annotations

import math

import pytest

from drivers.kinematic.clearance import Clearance
from robotcore.description import Box, Cylinder, Start, Walls
from robotcore.description.generation.clearance import gap_between
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot
from tests.drivers.kinematic.rooms import (
    ROVER,
    ball,
    box,
    drive,
    let_pass,
    opened,
    post,
    room,
    truth_of,
    wheel_angles,
)

FRONT = ROVER.body.front_x_m


def contacts(robot: Robot) -> int | None:
    return truth_of(robot).contacts()


def test_a_wall_stops_the_robot_within_a_step_of_it() -> None:
    with opened(room(walls=Walls(height_m=0.3))) as robot:
        drive(robot, 0.3, 0.0, 10.0)
        front = truth_of(robot).pose().x + FRONT
    assert 2.0 - 0.3 / 240 < front <= 2.0


def test_pressing_on_is_one_contact() -> None:
    with opened(room(box(0.5, 0.0, 0.2, 0.2))) as robot:
        drive(robot, 0.3, 0.0, 20.0)
        assert contacts(robot) == 1


def test_coming_back_is_another_contact() -> None:
    with opened(room(box(0.5, 0.0, 0.2, 0.2))) as robot:
        for _ in range(3):
            drive(robot, 0.3, 0.0, 3.0)
            drive(robot, -0.1, 0.0, 1.0)
        assert contacts(robot) == 3


def test_two_things_touched_at_once_are_two_contacts() -> None:
    pair = (box(0.5, 0.2, 0.2, 0.3, name="one"), box(0.5, -0.2, 0.2, 0.3, name="two"))
    with opened(room(*pair)) as robot:
        drive(robot, 0.3, 0.0, 3.0)
        assert contacts(robot) == 2


def test_a_ball_is_touched_where_it_is_round() -> None:
    with opened(room(ball(0.5, 0.0))) as robot:
        drive(robot, 0.3, 0.0, 4.0)
        assert truth_of(robot).pose().x + FRONT == pytest.approx(0.4, abs=0.3 / 240)
        assert contacts(robot) == 1


def test_wheels_stall_while_the_robot_is_held_up() -> None:
    with opened(room(box(0.5, 0.0, 0.2, 0.2))) as robot:
        for motor in robot.motors.values():
            motor.set_velocity(9.0)
        let_pass(robot, 3.0)
        before = wheel_angles(robot)
        let_pass(robot, 1.0)
        assert wheel_angles(robot) == before
        assert truth_of(robot).twist().linear < 0.03


def test_a_robot_that_touches_can_drive_away() -> None:
    with opened(room(box(0.5, 0.0, 0.2, 0.2))) as robot:
        drive(robot, 0.3, 0.0, 3.0)
        touching = truth_of(robot).pose().x
        drive(robot, -0.2, 0.0, 1.0)
        let_pass(robot, 1.0)
        assert truth_of(robot).pose().x == pytest.approx(touching - 0.2, abs=1e-3)


def test_a_robot_that_starts_in_something_can_leave_but_not_go_deeper() -> None:
    world = room(box(0.2, 0.0, 0.2, 0.2))
    with opened(world) as robot:
        drive(robot, 0.2, 0.0, 1.0)
        assert truth_of(robot).pose().x == 0.0
        drive(robot, -0.2, 0.0, 1.0)
        assert truth_of(robot).pose().x < -0.15


def test_turning_sweeps_the_corners_of_the_body() -> None:
    beside = box(0.1, 0.25, 0.2, 0.2)
    with opened(room(beside)) as robot:
        drive(robot, 0.0, 1.0, 3.0)
        assert contacts(robot) == 1
        assert truth_of(robot).pose().heading < 1.0


@pytest.mark.parametrize("thing", [box(0.0, 0.8, 0.5, 0.1, yaw=0.4), post(0.7, 0.5, 0.1), ball(-0.6, 0.6)])
def test_nothing_is_ever_entered_on_a_winding_way(thing: Box | Cylinder) -> None:
    world = room(thing, walls=Walls(height_m=0.3))
    clearances = Clearance(ROVER.body.footprint, world)
    with opened(world) as robot:
        for tick in range(400):
            linear, angular = 0.3 * math.sin(tick / 9), 2.0 * math.sin(tick / 23)
            drive(robot, linear, angular, 0.05)
            assert clearances.gaps(truth_of(robot).pose()).min() >= 0


def test_gaps_agree_with_the_descriptions_own() -> None:
    things = (box(0.9, 0.3, 0.5, 0.2, yaw=0.7), post(-0.5, 0.8, 0.2))
    clearances = Clearance(ROVER.body.footprint, room(*things))
    for heading in (0.0, 1.0, 2.5, -2.0):
        pose = Pose(0.2, 0.1, heading)
        body = tuple(pose.to_world(x, y) for x, y in ROVER.body.footprint)
        expected = [gap_between(body, thing.outline) for thing in things]
        assert clearances.gaps(pose) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    "x, y, expected",
    [
        (FRONT + 0.3, 0.0, 0.2),
        (FRONT + 0.3, ROVER.body.width_m / 2 + 0.4, 0.4),
        (0.0, 0.0, -ROVER.body.length_m / 2 + ROVER.body.centre_x_m - 0.1),
    ],
    ids=["ahead", "off a corner", "inside"],
)
def test_the_gap_to_a_ball_is_the_distance_to_its_circle(x: float, y: float, expected: float) -> None:
    gaps = Clearance(ROVER.body.footprint, room(ball(x, y))).gaps(Pose(0.0, 0.0, 0.0))
    assert gaps == pytest.approx([expected])


def test_an_empty_world_has_no_contacts() -> None:
    with opened(room(start=Start(x_m=1.9))) as robot:
        drive(robot, 0.3, 0.0, 3.0)
        assert truth_of(robot).pose().x > 2.5
        assert contacts(robot) == 0
