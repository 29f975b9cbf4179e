"""The scene that the second recorded session begins with: a robot that rolls well, and a wall in front of it."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import ForceSensor, Primitive, Shape
from tests.doubles.coppeliasim.scene.poses import Transform
from tests.doubles.coppeliasim.scenes.parts import floor, moving, still, wheel_joint

FIRST_HANDLE = 166
HEIGHT_M, WHEEL_M, TRACK_M, CASTER_M = 0.06, 0.0325, 0.155, 0.015
LAG_S = 0.025
"""What starting costs the real robot: 7 mm of way at 9 rad/s."""

GREEN, WHITE = (0.0, 1.0, 0.0), (1.0, 1.0, 1.0)


def second_scene() -> Simulator:
    """Return the objects 166 to 176, placed as the recorded contacts, depths and pictures tell."""
    graph = Graph(FIRST_HANDLE)
    graph.add(floor(6.0, 6.0, WHITE))
    body = moving("rover", (0.2, 0.14, 0.06), Transform((0.0, 0.0, HEIGHT_M)), Primitive.CUBOID, 1.0)
    graph.add(body)
    for side, sign in (("left", 1), ("right", -1)):
        _add_wheel(graph, body, side, sign * TRACK_M / 2)
    for i, x in enumerate((-0.07, 0.07)):
        _add_caster(graph, body, f"caster{i}", x)
    graph.add(still("wall", (0.1, 1.5, 0.6), Transform((0.54, 0.0, 0.3)), GREEN))
    return Simulator(graph, can_detect=False)


def _add_wheel(graph: Graph, body: Shape, side: str, y: float) -> None:
    joint = graph.add(wheel_joint(side, (0.0, y, WHEEL_M - HEIGHT_M), LAG_S), body)
    graph.add(moving(f"{side}Wheel", (2 * WHEEL_M,) * 3, Transform(), Primitive.SPHEROID, 0.05), joint)


def _add_caster(graph: Graph, body: Shape, alias: str, x: float) -> None:
    at = Transform((x, 0.0, CASTER_M - HEIGHT_M))
    caster = graph.add(moving(alias, (2 * CASTER_M,) * 3, at, Primitive.SPHEROID, 0.02), body)
    graph.move_under(caster, graph.add(ForceSensor(f"{alias}Link", local=at), body))
