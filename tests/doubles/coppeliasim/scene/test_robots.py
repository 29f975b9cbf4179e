"""Robots in a scene: motion, obstacles, and restoring them after a stop."""

from __future__ import annotations

import math

import pytest

from robotcore.geometry import Pose
from tests.doubles.coppeliasim.scene import Graph, Simulator, State
from tests.doubles.coppeliasim.scene.objects import Joint, Primitive, Shape
from tests.doubles.coppeliasim.scene.poses import Transform, multiply
from tests.doubles.coppeliasim.scene.rover import find_drives
from tests.doubles.coppeliasim.scenes.parts import (
    TO_THE_LEFT,
    create_dynamic,
    create_floor,
    create_static,
    create_wheel_joint,
)

RADIUS, TRACK = 0.04, 0.16
WHEEL = (2 * RADIUS, 2 * RADIUS, 0.02)
ABOUT_X = (1.0, 0.0, 0.0, 0.0)


@pytest.fixture
def simulator() -> Simulator:
    graph = Graph()
    graph.add(create_floor(6.0, 6.0))
    body = graph.add(create_dynamic("rover", (0.2, 0.12, 0.05), Transform((0.5, 0.2, 0.06)), Primitive.CUBOID, 1.0))
    for side, y in (("left", TRACK / 2), ("right", -TRACK / 2)):
        joint = graph.add(create_wheel_joint(side, (-0.03, y, RADIUS - 0.06)), body)
        graph.add(create_dynamic(f"{side}Wheel", WHEEL, Transform(), Primitive.SPHEROID, 0.05), joint)
    return Simulator(graph)


def joint(simulator: Simulator, name: str) -> Joint:
    found = simulator.graph.find(f"/rover/{name}")
    assert isinstance(found, Joint)
    return found


def drive(simulator: Simulator, left: float, right: float, steps: int) -> None:
    with simulator.lock:
        simulator.start()
        joint(simulator, "left").target_velocity = left
        joint(simulator, "right").target_velocity = right
        for _ in range(steps):
            simulator.advance()


def axle(simulator: Simulator) -> Pose:
    return find_drives(simulator.graph)[0].start


def test_arc_equals_the_closed_form(simulator: Simulator) -> None:
    drive(simulator, 2.0, 3.0, steps=40)
    expected = Pose(0.47, 0.2, 0.0).advance(2.5 * RADIUS * 2.0, 1.0 * RADIUS / TRACK * 2.0)
    assert axle(simulator) == pytest.approx(expected, abs=1e-9)


def test_reversed_joint_drives_backwards(simulator: Simulator) -> None:
    right = joint(simulator, "right")
    right.local = Transform(right.local.position, multiply(TO_THE_LEFT, ABOUT_X))
    simulator.graph.revision += 1
    drive(simulator, 2.0, -2.0, steps=20)
    assert axle(simulator) == pytest.approx((0.47 + 2.0 * RADIUS, 0.2, 0.0), abs=1e-9)
    assert right.position == pytest.approx(-2.0)


def test_wheel_with_a_nan_target_stands_still(simulator: Simulator) -> None:
    drive(simulator, math.nan, math.nan, steps=5)
    assert axle(simulator) == pytest.approx((0.47, 0.2, 0.0))


def test_cyclic_joint_wraps_at_half_a_turn(simulator: Simulator) -> None:
    joint(simulator, "right").is_cyclic = False
    drive(simulator, 4.0, 4.0, steps=20)
    assert joint(simulator, "left").position == pytest.approx(4.0 - math.tau)
    assert joint(simulator, "right").position == pytest.approx(4.0)


@pytest.mark.parametrize(
    "node",
    [
        Shape("box", size=(0.1, 0.5, 0.3), local=Transform((1.0, 0.2, 0.15))),
        Shape("post", primitive=Primitive.CYLINDER, size=(0.1, 0.1, 0.3), local=Transform((1.0, 0.2, 0.15))),
        Shape("ball", primitive=Primitive.SPHEROID, size=(0.1, 0.1, 0.1), local=Transform((1.0, 0.2, 0.05))),
    ],
    ids=lambda node: node.alias,
)
def test_obstacles_stop_the_body_and_are_contacts(simulator: Simulator, node: Shape) -> None:
    simulator.graph.add(node)
    drive(simulator, 5.0, 5.0, steps=60)
    body = simulator.graph.find("/rover")
    assert body
    front = simulator.graph.pose(body).position[0] + 0.1
    assert front == pytest.approx(0.95, abs=0.002)
    touched = [each for each in simulator.contacts() if node.handle in each[:2]]
    assert [each.first for each in touched] == [body.handle]
    assert touched[0].normal == pytest.approx((-1.0, 0.0, 0.0), abs=0.01)


def test_shape_added_during_a_run_stops_the_robot(simulator: Simulator) -> None:
    drive(simulator, 5.0, 5.0, steps=5)
    simulator.graph.add(create_static("box", (0.1, 0.5, 0.3), Transform((1.0, 0.2, 0.15))))
    with simulator.lock:
        for _ in range(60):
            simulator.advance()
    assert axle(simulator).x + 0.13 == pytest.approx(0.95, abs=0.002)


@pytest.mark.parametrize("height", [-0.1, 0.3])
def test_shape_below_or_above_the_body_does_not_stop_it(simulator: Simulator, height: float) -> None:
    simulator.graph.add(create_static("beam", (0.1, 0.5, 0.1), Transform((1.0, 0.2, height))))
    drive(simulator, 5.0, 5.0, steps=60)
    assert axle(simulator).x == pytest.approx(0.47 + 5.0 * RADIUS * 3.0)


def test_wheels_touch_the_floor_during_a_run(simulator: Simulator) -> None:
    drive(simulator, 0.0, 0.0, steps=1)
    assert len(simulator.contacts()) == 2
    with simulator.lock:
        simulator.stop()
        for _ in range(3):
            simulator.advance()
    assert simulator.contacts() == []


def test_moved_robot_continues_from_its_new_place(simulator: Simulator) -> None:
    drive(simulator, 2.0, 2.0, steps=10)
    body = simulator.graph.find("/rover")
    assert body
    simulator.graph.put(body, Transform.rotated(math.pi / 2, (1.0, 1.0, 0.06)))
    with simulator.lock:
        simulator.advance()
    assert axle(simulator) == pytest.approx((1.0, 1.0 - 0.03 + 2.0 * RADIUS * 0.05, math.pi / 2))


def test_stop_restores_objects_and_removes_new_ones(simulator: Simulator) -> None:
    drive(simulator, 2.0, 2.0, steps=10)
    made = simulator.graph.add(Shape("made"))
    with simulator.lock:
        simulator.stop()
        states = [simulator.state]
        for _ in range(3):
            simulator.advance()
            states.append(simulator.state)
    assert states == [State.RUNNING, State.ABOUT_TO_STOP, State.LAST_BEFORE_STOP, State.STOPPED]
    assert axle(simulator) == (0.47, 0.2, 0.0)
    assert joint(simulator, "left").target_velocity == 0.0
    assert made.handle not in simulator.graph


def test_time_step_is_set_only_while_stopped(simulator: Simulator) -> None:
    assert simulator.set_time_step(0.02)
    drive(simulator, 0.0, 0.0, steps=3)
    assert not simulator.set_time_step(0.05)
    assert simulator.time == pytest.approx(0.06)
