"""Shapes: colours, masses, sizes."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import Shape
from tests.doubles.coppeliasim.scene.poses import ORIGIN
from tests.doubles.coppeliasim.zmq.functions.registry import floats, function
from tests.doubles.coppeliasim.zmq.session import Session

AMBIENT_DIFFUSE = 0


@function("setShapeColor")
def set_shape_color(session: Session, shape: Shape, name: Any, component: int, colour: list) -> int:  # type: ignore[type-arg]
    if component == AMBIENT_DIFFUSE:
        red, green, blue = floats(colour, 3)
        shape.colour = (red, green, blue)
        session.simulator.graph.revision += 1
    else:
        session.shared.kept[shape, "colour", component] = [float(part) for part in colour[:3]]
    return 1


@function("getShapeColor")
def get_shape_color(session: Session, shape: Shape, name: Any, component: int) -> tuple[int, list[float]]:
    if component == AMBIENT_DIFFUSE:
        return 1, list(shape.colour)
    if (shape, "colour", component) not in session.shared.kept:
        raise SceneError(f"the double knows colour component {component} only where it was set.")
    return 1, session.shared.kept[shape, "colour", component]


@function("computeMassAndInertia")
def compute_mass_and_inertia(session: Session, shape: Shape, density: float) -> int:
    shape.mass = density * shape.volume
    return 1


@function("setShapeMass")
def set_shape_mass(session: Session, shape: Shape, mass: float) -> None:
    shape.mass = mass


@function("getShapeMass")
def get_shape_mass(session: Session, shape: Shape) -> float:
    return shape.mass


@function("setShapeInertia")
def set_shape_inertia(session: Session, shape: Shape, inertia: list, frame: list) -> None:  # type: ignore[type-arg]
    session.shared.kept[shape, "inertia"] = ([float(part) for part in inertia], [float(part) for part in frame])


@function("getShapeBB")
def get_shape_bb(session: Session, shape: Shape) -> tuple[list[float], list[float]]:
    return list(shape.size), ORIGIN.pose


@function("getShapeGeomInfo")
def get_shape_geom_info(session: Session, shape: Shape) -> tuple[int, int, list[float]]:
    """Bit 1 of the first value: a pure primitive; bit 2: convex."""
    return 6, int(shape.primitive), [*shape.size, 0.0]


@function("resetDynamicObject")
def reset_dynamic_object(session: Session, shape: Shape) -> int:
    """Nothing is remembered of a shape that this would have to forget."""
    return 1
