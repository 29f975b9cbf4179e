"""The scene that the second recorded session begins with: a robot that rolls well, and a wall in front of it."""

from __future__ import annotations

import math

from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import ForceSensor, Joint, JointMode, Primitive, Shape
from tests.doubles.coppeliasim.scene.poses import Quaternion, Transform, Vector

FIRST_HANDLE = 166
TO_THE_LEFT: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))

WHEEL_M, TRACK_M, CASTER_M = 0.0325, 0.155, 0.015
LAG_S = 0.025
"""What starting costs the real robot: 7 mm of way at 9 rad/s."""

GREEN = (0.0, 1.0, 0.0)


def fill_second_scene(simulator: Simulator) -> None:
    """Fill a simulator with the objects 166 to 176, placed as the recorded contacts, depths and pictures tell."""
    graph = simulator.graph
    graph.clear(FIRST_HANDLE)
    graph.add(_still("floor", (6.0, 6.0, 0.1), (0.0, 0.0, -0.05)))
    body = graph.add(_moving("rover", Primitive.CUBOID, (0.2, 0.14, 0.06), (0.0, 0.0, 0.06)))
    for side, sign in (("left", 1), ("right", -1)):
        _add_wheel(graph, body, side, sign * TRACK_M / 2)
    for i, x in enumerate((-0.07, 0.07)):
        _add_caster(graph, body, f"caster{i}", x)
    graph.add(_still("wall", (0.1, 1.5, 0.6), (0.54, 0.0, 0.3), GREEN))


def _add_wheel(graph: Graph, body: Shape, side: str, y: float) -> None:
    hub = Transform((0.0, y, WHEEL_M), TO_THE_LEFT)
    joint = graph.add(Joint(side, control=JointMode.VELOCITY, lag=LAG_S), body)
    graph.put(joint, hub)
    wheel = graph.add(_moving(f"{side}Wheel", Primitive.SPHEROID, (2 * WHEEL_M,) * 3, (0.0, 0.0, 0.0)), joint)
    graph.put(wheel, hub)


def _add_caster(graph: Graph, body: Shape, alias: str, x: float) -> None:
    caster = graph.add(_moving(alias, Primitive.SPHEROID, (2 * CASTER_M,) * 3, (x, 0.0, CASTER_M)))
    link = graph.add(ForceSensor(f"{alias}Link", local=Transform((x, 0.0, CASTER_M))))
    graph.move_under(link, body)
    graph.move_under(caster, link)


def _still(alias: str, size: Vector, at: Vector, colour: Vector = (0.95, 0.95, 0.95)) -> Shape:
    return Shape(alias, size=size, local=Transform(at), colour=colour, is_respondable=True)


def _moving(alias: str, primitive: Primitive, size: Vector, at: Vector) -> Shape:
    return Shape(alias, primitive=primitive, size=size, local=Transform(at), is_static=False, is_respondable=True)
