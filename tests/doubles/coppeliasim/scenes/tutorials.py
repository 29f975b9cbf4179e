"""The scenes of V-REP's tutorials: bubbleRob among obstacles, and the camera relay.

bubbleRob is a ball on two wheels and a slider, with a nose. Each object has its present path and its old name:
``/bubbleRob/leftMotor`` is also ``bubbleRob_leftMotor``.
"""

from __future__ import annotations

import math

from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import Joint, Primitive, ProximitySensor, Shape, VisionSensor
from tests.doubles.coppeliasim.scene.poses import Transform, Vector
from tests.doubles.coppeliasim.scenes.parts import AHEAD, HIGH, add_wheel, create_ball, create_floor

BODY_M, CENTRE_Z_M = 0.2, 0.12
WHEEL_M, SIDE_M, AXLE_X_M = 0.04, 0.1, 0.05
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
        post = Shape(f"post{i}", primitive=Primitive.CYLINDER, size=(0.2, 0.2, 0.4), colour=(0.8, 0.75, 0.3))
        post.local = Transform((x, y, 0.2))
        graph.add(post)
    out, across, along = (ARENA_M + WALL_M) / 2, (WALL_M, ARENA_M), (ARENA_M + 2 * WALL_M, WALL_M)
    walls = (("north", along, 0.0, out), ("south", along, 0.0, -out), ("east", across, out, 0.0))
    for name, size, x, y in (*walls, ("west", across, -out, 0.0)):
        wall = Shape(name, size=(*size, WALL_HEIGHT_M), colour=(0.9, 0.9, 0.9))
        wall.local = Transform((x, y, WALL_HEIGHT_M / 2))
        graph.add(wall)
    graph.add(create_ball("ball", 0.1, -1.3, 1.5, GREEN))
    _add_bubblerob(graph)
    graph.add(_create_camera("v1", HIGH, takes_external_pictures=True))
    return Simulator(graph)


def _add_bubblerob(graph: Graph) -> None:
    body = Shape("bubbleRob", primitive=Primitive.SPHEROID, size=(BODY_M,) * 3, colour=BLUE, is_static=False)
    body.local, body.is_model_base = Transform((0.0, 0.0, CENTRE_Z_M)), True
    graph.add(body)
    for side, y in (("left", SIDE_M), ("right", -SIDE_M)):
        add_wheel(graph, body, Joint(f"{side}Motor"), (AXLE_X_M, y, WHEEL_M - CENTRE_Z_M), WHEEL_M, f"{side}Wheel")
    slider = Shape("slider", primitive=Primitive.SPHEROID, size=(2 * SLIDER_M,) * 3, is_static=False)
    slider.local = Transform((SLIDER_X_M, 0.0, SLIDER_M - CENTRE_Z_M))
    graph.add(slider, body)
    ahead = Transform((NOSE_X_M, 0.0, 0.0), AHEAD)
    graph.add(ProximitySensor("sensingNose", reach=NOSE_REACH_M, cone=NOSE_RAD, local=ahead), body)
    graph.add(_create_camera("visionSensor", ahead), body)
    for part in graph.tree(body.children):
        part.flat_name = f"bubbleRob_{part.alias}"


def relay_scene() -> Simulator:
    """Return the scene of the camera relay. ``/v0`` points along x at the ball, and ``/v1`` shows received pictures."""
    graph = Graph()
    graph.add(create_floor(5.0, 5.0))
    graph.add(create_ball("ball", 0.1, 1.0, 0.15, GREEN))
    graph.add(_create_camera("v0", Transform((0.0, 0.0, 0.3), AHEAD)))
    graph.add(_create_camera("v1", HIGH, takes_external_pictures=True))
    return Simulator(graph)


def _create_camera(alias: str, at: Transform, *, takes_external_pictures: bool = False) -> VisionSensor:
    sensor = VisionSensor(alias, width=SIGHT_PX, height=SIGHT_PX, angle=SIGHT_RAD, local=at)
    sensor.takes_external_pictures = takes_external_pictures
    return sensor
