"""Finds differential-drive robots in a scene: a dynamic body with two velocity-controlled joints that carry wheels."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from robotcore.geometry import DifferentialGeometry, Pose
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Joint, JointMode, Primitive, Shape, Thing
from tests.doubles.coppeliasim.scene.poses import Vector

LEVEL = 0.99
"""Axes whose directions agree to this cosine are one axle."""


@dataclass(frozen=True)
class Hub:
    """A joint with its wheel in the world: the wheel's centre, and the axis of positive turns."""

    joint: Joint
    centre: Vector
    axis: Vector
    radius: float


@dataclass(frozen=True)
class Drive:
    """A body on two driven wheels. A sign is -1 where positive turns of that joint drive backwards.

    ``start`` is where the middle of the axle is, and where forward is.
    """

    body: Shape
    left: Joint
    right: Joint
    left_sign: float
    right_sign: float
    start: Pose
    geometry: DifferentialGeometry


def drives_of(graph: Graph) -> list[Drive]:
    """Return the robots of a scene, as it is now."""
    hubs: dict[Shape, list[Hub]] = {}
    for joint in graph.all_of(Joint):
        if (body := _body_of(joint)) and (hub := _hub_of(graph, joint)):
            hubs.setdefault(body, []).append(hub)
    return [_drive(body, *pair) for body, pair in hubs.items() if _is_axle(pair)]


def _body_of(joint: Joint) -> Shape | None:
    """Return the dynamic body that a driven joint sits on, or None."""
    if not (joint.is_dynamic and joint.control == JointMode.VELOCITY):
        return None
    return next((thing for thing in _above(joint) if isinstance(thing, Shape) and not thing.is_static), None)


def _above(thing: Thing) -> Iterable[Thing]:
    while thing.parent:
        thing = thing.parent
        yield thing


def _hub_of(graph: Graph, joint: Joint) -> Hub | None:
    """Return a joint's wheel: a round dynamic shape below it."""
    for thing in graph.tree(joint.children):
        if isinstance(thing, Shape) and not thing.is_static and thing.primitive is not Primitive.CUBOID:
            axis = graph.pose(joint).axes[2]
            return Hub(joint, graph.pose(thing).position, axis, max(thing.size[:2]) / 2)
    return None


def _is_axle(hubs: list[Hub]) -> bool:
    if len(hubs) != 2:
        return False
    one, other = (hub.axis for hub in hubs)
    along = sum(a * b for a, b in zip(one, other, strict=True))
    return abs(along) > LEVEL and abs(one[2]) < 1 - LEVEL


def _drive(body: Shape, one: Hub, other: Hub) -> Drive:
    """Forward is where positive turns of the first joint drive: its axis points to the left then."""
    to_left = one.axis
    left, right = sorted((one, other), key=lambda hub: -_along(hub.centre, to_left))
    middle = [(a + b) / 2 for a, b in zip(left.centre, right.centre, strict=True)]
    return Drive(
        body,
        left.joint,
        right.joint,
        math.copysign(1.0, _along(left.axis, to_left)),
        math.copysign(1.0, _along(right.axis, to_left)),
        Pose(middle[0], middle[1], math.atan2(-to_left[0], to_left[1])),
        DifferentialGeometry(left.radius, _along(left.centre, to_left) - _along(right.centre, to_left)),
    )


def _along(vector: Vector, axis: Vector) -> float:
    """Return how far a vector goes along an axis, in plan."""
    return vector[0] * axis[0] + vector[1] * axis[1]
