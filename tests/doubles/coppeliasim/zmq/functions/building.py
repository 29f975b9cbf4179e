"""The functions that create objects."""

from __future__ import annotations

import math

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import (
    Dummy,
    ForceSensor,
    Joint,
    Primitive,
    ProximitySensor,
    Shape,
    VisionSensor,
)
from tests.doubles.coppeliasim.zmq.functions.registry import floats, function
from tests.doubles.coppeliasim.zmq.session import Session

REVOLUTE = 10
DYNAMIC = 5
DENSITY = 500.0
"""The density of new shapes in kg/m³."""
PYRAMID, CONE, RAY = 30, 33, 34

SHAPE_NAMES = {Primitive.CUBOID: "Cuboid", Primitive.SPHEROID: "Sphere", Primitive.CYLINDER: "Cylinder"}


@function("createPrimitiveShape")
def create_primitive_shape(session: Session, primitive: int, sizes: list[float], options: int = 0) -> int:
    if primitive not in SHAPE_NAMES:
        raise SceneError(f"the double has cuboids, spheroids and cylinders only, not primitive {primitive}.")
    kind, (x, y, z) = Primitive(primitive), floats(sizes, 3)
    shape = Shape(SHAPE_NAMES[kind], primitive=kind, size=(x, y, z))
    shape.mass = DENSITY * shape.volume
    return session.simulator.graph.add(shape).handle


@function("createPureShape")
def create_pure_shape(session: Session, kind: int, options: int, sizes: list[float], mass: float = 1.0) -> int:
    """`create_primitive_shape` before CoppeliaSim 4.4.

    Kinds: 0 cuboid, 1 sphere, 2 cylinder. Options: bit 3 respondable, bit 4 static.
    """
    primitive = list(Primitive)[kind]
    x, y, z = floats(sizes, 3)
    shape = Shape(
        SHAPE_NAMES[primitive],
        primitive=primitive,
        size=(x, y, z),
        is_static=bool(options & 16),
        is_respondable=bool(options & 8),
        mass=mass,
    )
    return session.simulator.graph.add(shape).handle


@function("createJoint")
def create_joint(session: Session, kind: int, mode: int, options: int = 0, sizes: list[float] | None = None) -> int:
    if kind != REVOLUTE:
        raise SceneError(f"the double has revolute joints only, not type {kind}.")
    return session.simulator.graph.add(Joint("Revolute_joint", is_dynamic=mode == DYNAMIC)).handle


@function("createForceSensor")
def create_force_sensor(session: Session, options: int, ints: list[int], floats: list[float]) -> int:
    return session.simulator.graph.add(ForceSensor("forceSensor")).handle


@function("createDummy")
def create_dummy(session: Session, size: float = 0.01) -> int:
    return session.simulator.graph.add(Dummy("dummy")).handle


@function("createVisionSensor")
def create_vision_sensor(session: Session, options: int, ints: list[int], floats: list[float]) -> int:
    """Create a vision sensor.

    Bits of the options: 0 explicit handling, 1 perspective, 4 external input, 7 own background.
    """
    if not options & 2:
        raise SceneError("the double has no orthographic vision sensors.")
    near, far, angle = (float(number) for number in floats[:3])
    sensor = VisionSensor(
        "visionSensor",
        explicit=bool(options & 1),
        width=int(ints[0]),
        height=int(ints[1]),
        angle=angle,
        near=near,
        far=far,
        takes_external_pictures=bool(options & 16),
        background=(float(floats[6]), float(floats[7]), float(floats[8])) if options & 128 else None,
    )
    return session.simulator.graph.add(sensor).handle


@function("createProximitySensor")
def create_proximity_sensor(
    session: Session, kind: int, subtype: int, options: int, ints: list[int], floats: list[float]
) -> int:
    """Create a proximity sensor. The cone angle of a pyramid is its horizontal opening angle."""
    if kind not in {PYRAMID, CONE, RAY}:
        raise SceneError(f"the double has pyramids, cones and rays only, not proximity sensors of type {kind}.")
    numbers = [float(number) for number in floats]
    sensor = ProximitySensor(
        "proximitySensor",
        explicit=bool(options & 1),
        offset=numbers[0],
        reach=numbers[1],
        cone=_compute_cone(kind, numbers),
    )
    return session.simulator.graph.add(sensor).handle


def _compute_cone(kind: int, numbers: list[float]) -> float:
    if kind == CONE:
        return min(numbers[9], math.pi - 1e-3)
    if kind == PYRAMID and numbers[1]:
        return 2 * math.atan2((numbers[4] - numbers[2]) / 2, numbers[1])
    return 0.0
