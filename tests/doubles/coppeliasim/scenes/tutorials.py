"""The scenes of V-REP's tutorials: bubbleRob among obstacles, and the camera relay.

bubbleRob is a ball on two wheels and a slider, with a nose. Each object has its present path and its old name:
``/bubbleRob/leftMotor`` is also ``bubbleRob_leftMotor``.
"""

from __future__ import annotations

import math
from functools import partial

from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import Node, Primitive, ProximitySensor, Shape, VisionSensor
from tests.doubles.coppeliasim.scene.poses import Transform, Vector
from tests.doubles.coppeliasim.scenes.parts import (
    AHEAD,
    create_ball,
    create_dynamic,
    create_floor,
    create_static,
    create_wheel_joint,
)

BODY_M, CENTRE_Z_M = 0.2, 0.12
WHEEL_M, WHEEL_WIDTH_M, SIDE_M, AXLE_X_M = 0.04, 0.03, 0.1, 0.05
SLIDER_M, SLIDER_X_M = 0.025, -0.07
NOSE_X_M, NOSE_REACH_M, NOSE_RAD = 0.1, 0.25, math.radians(30)
SIGHT_PX, SIGHT_RAD = 256, math.radians(60)

ARENA_M, WALL_M, WALL_HEIGHT_M = 4.0, 0.1, 0.3
GREEN: Vector = (0.15, 0.7, 0.25)
BLUE: Vector = (0.15, 0.3, 0.8)
POSTS = ((1.0, 0.3), (-0.9, 1.1), (0.4, -1.2), (-1.2, -0.8))


def bubblerob_scene() -> Simulator:
    """Return bubbleRob's scene, with a green ball and a second vision sensor ``/v1`` that shows received pictures."""
    graph = Graph()
    graph.add(create_floor(ARENA_M, ARENA_M))
    for i, (x, y) in enumerate(POSTS):
        post = create_static("post", (0.2, 0.2, 0.4), Transform((x, y, 0.2)), (0.8, 0.75, 0.3), Primitive.CYLINDER)
        graph.add(post).flat_name = f"post#{i}" if i else "post"
    for name, across, x, y in _walls():
        size = (WALL_M, ARENA_M, WALL_HEIGHT_M) if across else (ARENA_M + 2 * WALL_M, WALL_M, WALL_HEIGHT_M)
        graph.add(create_static(name, size, Transform((x, y, WALL_HEIGHT_M / 2)), (0.9, 0.9, 0.9)))
    graph.add(create_ball("ball", 0.1, -1.3, 1.5, GREEN))
    _add_bubblerob(graph)
    high = Transform((0.0, 0.0, 3.0))
    graph.add(VisionSensor("v1", width=SIGHT_PX, height=SIGHT_PX, local=high, takes_external_pictures=True))
    return Simulator(graph)


def _walls() -> tuple[tuple[str, bool, float, float], ...]:
    out = (ARENA_M + WALL_M) / 2
    return ("north", False, 0.0, out), ("south", False, 0.0, -out), ("east", True, out, 0.0), ("west", True, -out, 0.0)


def _add_bubblerob(graph: Graph) -> None:
    centre = Transform((0.0, 0.0, CENTRE_Z_M))
    body = create_dynamic("bubbleRob", (BODY_M,) * 3, centre, Primitive.SPHEROID, 4.2, BLUE)
    body.is_model_base = True
    graph.add(body)
    for side, sign in (("left", 1), ("right", -1)):
        _add_wheel(graph, body, side, sign * SIDE_M)
    slider = create_dynamic("slider", (2 * SLIDER_M,) * 3, _from_floor(SLIDER_X_M, SLIDER_M), Primitive.SPHEROID, 0.06)
    _name(graph.add(slider, body))
    nose = ProximitySensor("sensingNose", reach=NOSE_REACH_M, cone=NOSE_RAD)
    nose.local = Transform((NOSE_X_M, 0.0, 0.0), AHEAD)
    _name(graph.add(nose, body))
    camera = VisionSensor("visionSensor", width=SIGHT_PX, height=SIGHT_PX, angle=SIGHT_RAD)
    camera.local = Transform((NOSE_X_M, 0.0, 0.0), AHEAD)
    _name(graph.add(camera, body))


def _add_wheel(graph: Graph, body: Shape, side: str, y: float) -> None:
    joint = graph.add(create_wheel_joint(f"{side}Motor", _from_floor(AXLE_X_M, WHEEL_M, y).position), body)
    _name(joint)
    size = (2 * WHEEL_M, 2 * WHEEL_M, WHEEL_WIDTH_M)
    _name(graph.add(create_dynamic(f"{side}Wheel", size, Transform(), Primitive.CYLINDER, 0.15), joint))


def _name(part: Node) -> None:
    part.flat_name = f"bubbleRob_{part.alias}"


def _from_floor(x: float, z: float, y: float = 0.0) -> Transform:
    return Transform((x, y, z - CENTRE_Z_M))


def relay_scene() -> Simulator:
    """Return the scene of the camera relay. ``/v0`` points along x at the ball, and ``/v1`` shows received pictures."""
    graph = Graph()
    graph.add(create_floor(5.0, 5.0))
    graph.add(create_ball("ball", 0.1, 1.0, 0.15, (0.15, 0.7, 0.25)))
    sight = partial(VisionSensor, width=SIGHT_PX, height=SIGHT_PX, angle=SIGHT_RAD)
    graph.add(sight("v0", local=Transform((0.0, 0.0, 0.3), AHEAD)))
    graph.add(sight("v1", local=Transform((0.0, 0.0, 3.0)), takes_external_pictures=True))
    return Simulator(graph)
