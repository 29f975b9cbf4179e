"""Contacts of the robot with the things of a world."""

from __future__ import annotations

import math

import pytest

from drivers.kinematic.clearance import Clearance
from robotcore.description import Box, Cylinder, Walls
from robotcore.description.generation.gaps import compute_gap
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot
from tests.drivers.kinematic.rooms import (
    ROVER,
    ball,
    box,
    drive,
    get_truth,
    open_robot,
    post,
    read_wheel_angles,
    room,
    sleep,
)

FRONT = ROVER.body.front_x_m


def count_contacts(robot: Robot) -> int | None:
    return get_truth(robot).contacts()


def test_a_wall_stops_the_robot_within_a_step_of_it() -> None:
    with open_robot(room(walls=Walls(height_m=0.3))) as robot:
        drive(robot, 0.3, 0.0, 10.0)
        front = get_truth(robot).pose().x + FRONT
    assert 2.0 - 0.3 / 240 < front <= 2.0


@pytest.mark.slow
def test_contact_after_a_retreat_counts_again() -> None:
    with open_robot(room(box(0.5, 0.0, 0.2, 0.2))) as robot:
        for _ in range(3):
            drive(robot, 0.3, 0.0, 3.0)
            drive(robot, -0.1, 0.0, 1.0)
        assert count_contacts(robot) == 3


def test_wheels_stall_while_an_obstacle_stops_the_robot() -> None:
    with open_robot(room(box(0.5, 0.0, 0.2, 0.2))) as robot:
        for motor in robot.motors.values():
            motor.set_velocity(9.0)
        sleep(robot, 3.0)
        before = read_wheel_angles(robot)
        sleep(robot, 1.0)
        assert read_wheel_angles(robot) == before
        assert get_truth(robot).twist().linear < 0.03


def test_robot_that_overlaps_a_box_can_only_move_out() -> None:
    world = room(box(0.2, 0.0, 0.2, 0.2))
    with open_robot(world) as robot:
        drive(robot, 0.2, 0.0, 1.0)
        assert get_truth(robot).pose().x == 0.0
        drive(robot, -0.2, 0.0, 1.0)
        assert get_truth(robot).pose().x < -0.15


def test_turning_sweeps_the_corners_of_the_body() -> None:
    beside = box(0.1, 0.25, 0.2, 0.2)
    with open_robot(room(beside)) as robot:
        drive(robot, 0.0, 1.0, 3.0)
        assert count_contacts(robot) == 1
        assert get_truth(robot).pose().heading < 1.0


@pytest.mark.parametrize("thing", [box(0.0, 0.8, 0.5, 0.1, yaw=0.4), post(0.7, 0.5, 0.1), ball(-0.6, 0.6)])
def test_robot_on_a_winding_path_never_overlaps_a_body(thing: Box | Cylinder) -> None:
    world = room(thing, walls=Walls(height_m=0.3))
    clearances = Clearance(ROVER.body.footprint, world)
    with open_robot(world) as robot:
        for tick in range(400):
            linear, angular = 0.3 * math.sin(tick / 9), 2.0 * math.sin(tick / 23)
            drive(robot, linear, angular, 0.05)
            assert clearances.measure_gaps(get_truth(robot).pose()).min() >= 0


def test_gaps_equal_those_of_gap_between() -> None:
    things = (box(0.9, 0.3, 0.5, 0.2, yaw=0.7), post(-0.5, 0.8, 0.2))
    clearances = Clearance(ROVER.body.footprint, room(*things))
    for heading in (0.0, 1.0, 2.5, -2.0):
        pose = Pose(0.2, 0.1, heading)
        body = tuple(pose.to_world(x, y) for x, y in ROVER.body.footprint)
        expected = [compute_gap(body, thing.outline) for thing in things]
        assert clearances.measure_gaps(pose) == pytest.approx(expected, abs=1e-12)


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
    gaps = Clearance(ROVER.body.footprint, room(ball(x, y))).measure_gaps(Pose(0.0, 0.0, 0.0))
    assert gaps == pytest.approx([expected])
