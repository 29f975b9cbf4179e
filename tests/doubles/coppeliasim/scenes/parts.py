"""Parts of scenes, the default scene, and the scene of the second session."""

from __future__ import annotations

import math

from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import Camera, Dummy, ForceSensor, Joint, JointMode, Lamp, Primitive, Shape
from tests.doubles.coppeliasim.scene.poses import Quaternion, Transform, Vector

TO_THE_LEFT: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""The rotation of a wheel's joint: its z axis points to the robot's left, so positive velocities drive forward."""

AHEAD: Quaternion = (0.5, 0.5, 0.5, 0.5)
"""The rotation of a sensor that points along x, with y up."""

GREY: Vector = (0.75, 0.72, 0.69)


def create_static(
    alias: str, size: Vector, at: Transform, colour: Vector = GREY, primitive: Primitive = Primitive.CUBOID
) -> Shape:
    """Return a static shape."""
    return Shape(alias, primitive=primitive, size=size, local=at, colour=colour, is_respondable=True)


def create_dynamic(
    alias: str, size: Vector, at: Transform, primitive: Primitive, mass: float, colour: Vector = GREY
) -> Shape:
    """Return a dynamic shape of a robot."""
    return Shape(
        alias,
        primitive=primitive,
        size=size,
        local=at,
        colour=colour,
        is_static=False,
        is_respondable=True,
        mass=mass,
    )


def create_ball(alias: str, radius: float, x: float, y: float, colour: Vector) -> Shape:
    """Return a ball that lies on the floor."""
    return create_static(alias, (2 * radius,) * 3, Transform((x, y, radius)), colour, Primitive.SPHEROID)


def create_floor(length: float, width: float, colour: Vector = GREY) -> Shape:
    """Return a floor with its upper side at height 0."""
    return create_static("floor", (length, width, 0.1), Transform((0.0, 0.0, -0.05)), colour)


def create_wheel_joint(alias: str, at: Vector, lag: float = 0.0) -> Joint:
    """Return a wheel's joint at a position in the frame of the robot's body."""
    return Joint(alias, local=Transform(at, TO_THE_LEFT), control=JointMode.VELOCITY, lag=lag)


FIRST_HANDLE = 166
HEIGHT_M, WHEEL_M, TRACK_M, CASTER_M = 0.06, 0.0325, 0.155, 0.015
LAG_S = 0.025
"""The time constant of the motors, in seconds. With it, the robot lags by 7 mm at 9 rad/s as the real one does."""

GREEN, WHITE = (0.0, 1.0, 0.0), (1.0, 1.0, 1.0)


def second_scene() -> Simulator:
    """Return the scene of the second session. Its poses fit the recorded contacts, depths and pictures."""
    graph = Graph(FIRST_HANDLE)
    graph.add(create_floor(6.0, 6.0, WHITE))
    body = create_dynamic("rover", (0.2, 0.14, 0.06), Transform((0.0, 0.0, HEIGHT_M)), Primitive.CUBOID, 1.0)
    graph.add(body)
    for side, sign in (("left", 1), ("right", -1)):
        _add_wheel(graph, body, side, sign * TRACK_M / 2)
    for i, x in enumerate((-0.07, 0.07)):
        _add_caster(graph, body, f"caster{i}", x)
    graph.add(create_static("wall", (0.1, 1.5, 0.6), Transform((0.54, 0.0, 0.3)), GREEN))
    return Simulator(graph, can_detect=False)


def _add_wheel(graph: Graph, body: Shape, side: str, y: float) -> None:
    joint = graph.add(create_wheel_joint(side, (0.0, y, WHEEL_M - HEIGHT_M), LAG_S), body)
    graph.add(create_dynamic(f"{side}Wheel", (2 * WHEEL_M,) * 3, Transform(), Primitive.SPHEROID, 0.05), joint)


def _add_caster(graph: Graph, body: Shape, alias: str, x: float) -> None:
    at = Transform((x, 0.0, CASTER_M - HEIGHT_M))
    caster = graph.add(create_dynamic(alias, (2 * CASTER_M,) * 3, at, Primitive.SPHEROID, 0.02), body)
    graph.move_under(caster, graph.add(ForceSensor(f"{alias}Link", local=at), body))


FLOOR = "ResizableFloor_5_25"
SLAB_M = (5.0, 5.0, 0.1)
CAMERAS = ("XView", "YView", "ZView", "NXView", "NYView", "NZView")


def default_scene() -> Simulator:
    """Return a simulator in its state after the program's start."""
    simulator = Simulator()
    fill_default_scene(simulator)
    return simulator


def fill_default_scene(simulator: Simulator) -> None:
    """Remove all objects, and add the objects of the default scene with the handles 0 to 14."""
    simulator.clear_scene()
    graph = simulator.graph
    graph.add(Camera("DefaultCamera"))
    _add_floor(graph)
    lights = graph.add(Dummy("DefaultLights", is_model_base=True))
    for letter in "ABCD":
        graph.add(Lamp(f"DefaultLight{letter}"), lights)
    for view in CAMERAS:
        graph.add(Camera(f"Default{view}Camera"))


def _add_floor(graph: Graph) -> None:
    base = graph.add(Dummy(FLOOR, is_model_base=True))
    slab = Shape(f"{FLOOR}_element", size=SLAB_M, is_respondable=True, local=Transform((0.0, 0.0, -SLAB_M[2] / 2)))
    graph.add(Shape(f"{FLOOR}_visibleElement", size=SLAB_M), graph.add(slab, base))
