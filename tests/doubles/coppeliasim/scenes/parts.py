"""Parts of scenes, the default scene, and the scene of the recorded sessions."""

from __future__ import annotations

import math

from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import (
    Joint,
    JointMode,
    Lamp,
    Node,
    Primitive,
    ProximitySensor,
    Shape,
    Type,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import Quaternion, Transform, Vector

TO_THE_LEFT: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""The rotation of a wheel's joint: its z axis points to the robot's left, so positive velocities drive forward."""

AHEAD: Quaternion = (0.5, 0.5, 0.5, 0.5)
"""The rotation of a sensor that points along x, with y up."""

GREY: Vector = (0.75, 0.72, 0.69)
LAG_S = 0.025
"""The time constant of the motors, in seconds. With it, the robot lags by 7 mm at 9 rad/s as the real one does."""

HIGH = Transform((0.0, 0.0, 3.0))
"""The pose of a vision sensor that shows received pictures."""


def create_ball(alias: str, radius: float, x: float, y: float, colour: Vector) -> Shape:
    """Return a ball that lies on the floor."""
    size = (2 * radius,) * 3
    return Shape(alias, primitive=Primitive.SPHEROID, size=size, local=Transform((x, y, radius)), colour=colour)


def create_floor(length: float, width: float, colour: Vector = GREY) -> Shape:
    """Return a floor with its upper side at height 0."""
    return Shape("floor", size=(length, width, 0.1), local=Transform((0.0, 0.0, -0.05)), colour=colour)


def add_wheel(graph: Graph, body: Shape, joint: Joint, at: Vector, radius: float, alias: str) -> Shape:
    """Add a wheel's joint at a position in the frame of the robot's body, and return the wheel, which is below it."""
    joint.local, joint.control = Transform(at, TO_THE_LEFT), JointMode.VELOCITY
    wheel = Shape(alias, primitive=Primitive.CYLINDER, size=(2 * radius, 2 * radius, 0.03), is_static=False)
    return graph.add(wheel, graph.add(joint, body))


def rover_scene(first_handle: int) -> Simulator:
    """Return the scene of the legacy sessions: a floor, a robot that looks along x, and its camera."""
    graph = _create_rover(first_handle)
    _add_camera(graph)
    return Simulator(graph)


def coloured_scene() -> Simulator:
    """Return the scene of ``legacy-calls.json``: the robot, and a green, a red and a blue body in front of it."""
    graph = _create_rover(15, 0.03, 0.04, casters=1)
    _add_camera(graph)
    graph.add(VisionSensor("v1", width=16, height=12, takes_external_pictures=True))
    graph.add(create_ball("target", 0.1, 1.0, 0.0, (0.0, 1.0, 0.0)))
    for alias, colour, y, z in (("redLeft", (1.0, 0.0, 0.0), 0.4, 0.05), ("blueUp", (0.0, 0.0, 1.0), 0.0, 0.45)):
        graph.add(Shape(alias, size=(0.1, 0.1, 0.1), local=Transform((1.0, y, z)), colour=colour))
    graph.add(Node("cast out"))
    graph.add(ProximitySensor("sensingNose", local=Transform((0.0, 0.0, 5.0))))
    return Simulator(graph)


def walled_scene() -> Simulator:
    """Return the scene of ``zmq-session-2.jsonl``: the robot in front of a green wall."""
    graph = _create_rover(166)
    for joint in graph.all_of(Joint):
        joint.lag = LAG_S
    graph.add(Shape("wall", size=(0.1, 1.5, 0.6), local=Transform((0.54, 0.0, 0.3)), colour=(0.0, 1.0, 0.0)))
    return Simulator(graph, can_detect=False)


def _create_rover(first_handle: int, x: float = 0.0, wheel_radius: float = 0.0325, casters: int = 2) -> Graph:
    """Return the objects of a floor and a robot on it. ``x`` is the position of the body."""
    graph = Graph(first_handle)
    graph.add(create_floor(6.0, 6.0, (1.0, 1.0, 1.0)))
    body = graph.add(Shape("rover", size=(0.2, 0.12, 0.05), local=Transform((x, 0.0, 0.06)), is_static=False))
    for side, y in (("left", 0.08), ("right", -0.08)):
        add_wheel(graph, body, Joint(f"{side}Motor"), (-x, y, wheel_radius - 0.06), wheel_radius, f"{side}Wheel")
    for _ in range(casters):
        caster = graph.add(Shape("caster", primitive=Primitive.SPHEROID, size=(0.04,) * 3, is_static=False), body)
        graph.move_under(caster, graph.add(Node("link", Type.FORCE_SENSOR), body))
    return graph


def _add_camera(graph: Graph) -> None:
    camera = VisionSensor("camera", width=16, height=12, near=0.02, far=5.0)
    camera.local = Transform((0.105, 0.0, 0.04), AHEAD)
    graph.add(camera, graph.find("/rover"))


FLOOR = "ResizableFloor_5_25"
SLAB_M = (5.0, 5.0, 0.1)
CAMERAS = ("XView", "YView", "ZView", "NXView", "NYView", "NZView")


def default_scene() -> Simulator:
    """Return a simulator in its state after the program's start, with objects of the handles 0 to 14."""
    graph = Graph()
    graph.add(Node("DefaultCamera", Type.CAMERA))
    base = graph.add(Node(FLOOR, is_model_base=True))
    slab = graph.add(Shape(f"{FLOOR}_element", size=SLAB_M, local=Transform((0.0, 0.0, -SLAB_M[2] / 2))), base)
    graph.add(Shape(f"{FLOOR}_visibleElement", size=SLAB_M), slab)
    lights = graph.add(Node("DefaultLights", is_model_base=True))
    for letter in "ABCD":
        graph.add(Lamp(f"DefaultLight{letter}"), lights)
    for view in CAMERAS:
        graph.add(Node(f"Default{view}Camera", Type.CAMERA))
    return Simulator(graph)
