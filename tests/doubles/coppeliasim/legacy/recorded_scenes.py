"""The scenes in which the sessions were recorded, as far as their clients looked at them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import (
    Dummy,
    ForceSensor,
    Joint,
    JointMode,
    Primitive,
    ProximitySensor,
    Shape,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import Quaternion, Transform, Vector
from tests.doubles.coppeliasim.scene.simulator import Simulator

TO_THE_LEFT: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""A joint's axis, its z, points to the robot's left."""
AHEAD: Quaternion = (0.5, 0.5, 0.5, 0.5)
"""A sensor looks along its z, and up is its y."""


@dataclass(frozen=True)
class Robot:
    """What differs between the robots of the sessions; metres."""

    at: Vector = (0.0, 0.0, 0.06)
    wheel_radius: float = 0.0325
    casters: int = 2


def first_scene() -> Simulator:
    """Return the scene of ``legacy-wire.jsonl``: the one that the first ZeroMQ session builds."""
    graph = Graph(first_handle=15)
    _floor_and_robot(graph, Robot((0.03, 0.0, 0.06), 0.04, casters=1))
    graph.add(VisionSensor("v1", width=16, height=12, takes_external_pictures=True))
    ball = Shape("target", primitive=Primitive.SPHEROID, size=(0.2, 0.2, 0.2), colour=(0.0, 1.0, 0.0))
    red = Shape("redLeft", size=(0.1, 0.1, 0.1), colour=(1.0, 0.0, 0.0))
    blue = Shape("blueUp", size=(0.1, 0.1, 0.1), colour=(0.0, 0.0, 1.0))
    for shape, at in ((ball, (1.0, 0.0, 0.1)), (red, (1.0, 0.4, 0.05)), (blue, (1.0, 0.0, 0.45))):
        graph.put(graph.add(shape), Transform(at))
    graph.add(Dummy("cast out"))
    graph.put(graph.add(ProximitySensor("sensingNose")), Transform((0.0, 0.0, 5.0)))
    return Simulator(graph)


def later_scene(first_handle: int) -> Simulator:
    """Return the scene of ``legacy-wire-2.jsonl`` and ``legacy-wire-19999.jsonl``: a robot that rolls well, no more."""
    graph = Graph(first_handle)
    _floor_and_robot(graph, Robot())
    return Simulator(graph)


def _floor_and_robot(graph: Graph, robot: Robot) -> None:
    graph.put(graph.add(Shape("floor", size=(6.0, 6.0, 0.1))), Transform((0.0, 0.0, -0.05)))
    body = graph.add(Shape("rover", size=(0.2, 0.12, 0.05), is_static=False, is_respondable=True))
    graph.put(body, Transform(robot.at))
    for name, side in (("left", 1.0), ("right", -1.0)):
        at = Transform((0.0, side * 0.08, robot.wheel_radius), TO_THE_LEFT)
        joint = graph.add(Joint(f"{name}Motor", control=JointMode.VELOCITY), body)
        wheel = graph.add(_round(f"{name}Wheel", robot.wheel_radius), joint)
        graph.put(joint, at)
        graph.put(wheel, at)
    for _ in range(robot.casters):
        caster, link = graph.add(_round("caster", 0.02), body), graph.add(ForceSensor("link"), body)
        graph.move_under(caster, link)
        graph.put(link, Transform((0.1, 0.0, 0.02)))
    camera = graph.add(VisionSensor("camera", width=16, height=12, near=0.02, far=5.0), body)
    graph.put(camera, Transform((robot.at[0] + 0.105, 0.0, 0.1), AHEAD))


def _round(name: str, radius: float) -> Shape:
    size = (2 * radius, 2 * radius, 2 * radius)
    return Shape(name, primitive=Primitive.SPHEROID, size=size, is_static=False, is_respondable=True)
