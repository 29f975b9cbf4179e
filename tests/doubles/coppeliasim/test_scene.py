"""Scenes without a protocol: objects by path, motion, obstacles, pictures, depths, and the state after a stop."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from robotcore.description import load_robot, load_world
from robotcore.geometry import Pose
from robotcore.kinds.camera import CameraDescription
from robotcore.optics import CameraView
from robotcore.simulation.painter import Painter
from tests.doubles.coppeliasim.scene import Graph, Simulator, State
from tests.doubles.coppeliasim.scene.objects import (
    Joint,
    Node,
    Primitive,
    Shape,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import Transform
from tests.doubles.coppeliasim.scene.rover import find_drives
from tests.doubles.coppeliasim.scenes import described_scene, rover_scene
from tests.doubles.coppeliasim.scenes.parts import AHEAD, create_ball

ROVER, ARENA = load_robot("rover"), load_world("arena")
RADIUS, TRACK, FRONT = 0.0325, 0.16, 0.1


@pytest.fixture
def simulator() -> Iterator[Simulator]:
    simulator = rover_scene(0)
    with simulator.lock:
        yield simulator


def drive(simulator: Simulator, left: float, right: float, steps: int) -> None:
    """Drive the first robot of a scene with these velocities of the wheels."""
    (robot,) = find_drives(simulator.graph)
    simulator.start()
    robot.left.target_velocity, robot.right.target_velocity = left, right
    for _ in range(steps):
        simulator.advance()


def axle(simulator: Simulator) -> Pose:
    return find_drives(simulator.graph)[0].start


@pytest.mark.parametrize(
    "path, handle",
    [("/robot", 0), ("/robot/arm/hand", 2), ("/robot/hand", 2), ("/hand", 2), ("/wheel", 4), ("/robot/wheel", 3)],
)
def test_path_finds_an_object(path: str, handle: int) -> None:
    graph = Graph()
    robot = graph.add(Node("robot", is_model_base=True))
    arm = graph.add(Node("arm"), robot)
    graph.add(Node("hand"), arm)
    graph.add(Node("wheel"), robot)
    graph.add(Node("wheel"))
    assert graph.find(path) is graph[handle]
    assert [graph.find(graph.path(node)) for node in graph] == list(graph)
    assert [graph.find(path) for path in ("/arm/robot", "/unknown", "robot", "/", "/robot/", "")] == [None] * 6


def test_arc_equals_the_closed_form(simulator: Simulator) -> None:
    drive(simulator, 2.0, 3.0, steps=40)
    expected = Pose(0.0, 0.0, 0.0).advance(2.5 * RADIUS * 2.0, 1.0 * RADIUS / TRACK * 2.0)
    assert axle(simulator) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    "node",
    [
        Shape("box", size=(0.1, 0.5, 0.3), local=Transform((0.5, 0.0, 0.15))),
        Shape("post", primitive=Primitive.CYLINDER, size=(0.1, 0.1, 0.3), local=Transform((0.5, 0.0, 0.15))),
        create_ball("ball", 0.05, 0.5, 0.0, (0.0, 1.0, 0.0)),
    ],
    ids=lambda node: node.alias,
)
def test_obstacle_stops_the_body_and_is_a_contact(simulator: Simulator, node: Shape) -> None:
    simulator.graph.add(node)
    drive(simulator, 6.0, 6.0, steps=60)
    assert axle(simulator).x + FRONT == pytest.approx(0.45, abs=0.002)
    assert simulator.contacts() == [(simulator.graph.find("/rover"), node)]


def test_stop_restores_objects_and_removes_new_ones(simulator: Simulator) -> None:
    drive(simulator, 2.0, 2.0, steps=10)
    made = simulator.graph.add(Shape("made"))
    simulator.stop()
    states = [simulator.state]
    for _ in range(3):
        simulator.advance()
        states.append(simulator.state)
    assert states == [State.RUNNING, State.ABOUT_TO_STOP, State.LAST_BEFORE_STOP, State.STOPPED]
    assert axle(simulator) == (0.0, 0.0, 0.0)
    assert [joint.target_velocity for joint in simulator.graph.all_of(Joint)] == [0.0, 0.0]
    assert made.handle not in simulator.graph


def test_picture_equals_the_kinematic_one() -> None:
    simulator = described_scene(ROVER, ARENA)
    eye, description = simulator.graph.find("/rover/eye"), ROVER.first_of(CameraDescription)
    assert isinstance(eye, VisionSensor)
    assert description
    with simulator.lock:
        assert not simulator.picture(eye).any()
        drive(simulator, 0.0, 0.0, steps=1)
    picture = Painter(ARENA).picture(CameraView.of(description.intrinsics, description.mount, ARENA.start.pose))
    off = np.abs(simulator.picture(eye)[::-1, :, ::-1].astype(int) - picture)
    assert (off > 1).mean() < 0.002


def test_depths_are_along_the_optical_axis_from_left_to_right(simulator: Simulator) -> None:
    graph = simulator.graph
    graph.add(Shape("wall", size=(0.1, 4.0, 0.8), local=Transform((2.05, 0.0, 0.4))))
    graph.add(Shape("post on the right", size=(0.1, 0.1, 0.8), local=Transform((1.05, -0.5, 0.4))))
    sensor = graph.add(VisionSensor("eye", width=9, height=1, explicit=True, local=Transform((0.0, 0.0, 0.2), AHEAD)))
    simulator.handle(sensor)
    depths = simulator.depth(sensor)[0].tolist()
    assert depths[:7] == pytest.approx([2.0] * 7)
    assert min(depths[7:]) == pytest.approx(1.0)
