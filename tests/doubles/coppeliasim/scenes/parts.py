"""Parts that scenes are made of."""

from __future__ import annotations

import math

from tests.doubles.coppeliasim.scene.objects import Joint, JointMode, Primitive, Shape
from tests.doubles.coppeliasim.scene.poses import Quaternion, Transform, Vector

TO_THE_LEFT: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""The turn of a wheel's joint, whose axis, its z, points to the robot's left: positive velocities drive forward."""

AHEAD: Quaternion = (0.5, 0.5, 0.5, 0.5)
"""The turn of a sensor that looks along x, with up its y."""

GREY: Vector = (0.75, 0.72, 0.69)


def still(
    alias: str, size: Vector, at: Transform, colour: Vector = GREY, primitive: Primitive = Primitive.CUBOID
) -> Shape:
    """Return a shape that stands where it is, whatever drives against it."""
    return Shape(alias, primitive=primitive, size=size, local=at, colour=colour, is_respondable=True)


def moving(alias: str, size: Vector, at: Transform, primitive: Primitive, mass: float, colour: Vector = GREY) -> Shape:
    """Return a shape that is part of a robot."""
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


def ball(alias: str, radius: float, x: float, y: float, colour: Vector) -> Shape:
    """Return a ball that lies on the floor."""
    return still(alias, (2 * radius,) * 3, Transform((x, y, radius)), colour, Primitive.SPHEROID)


def floor(length: float, width: float, colour: Vector = GREY) -> Shape:
    """Return a slab whose upper side is at zero."""
    return still("floor", (length, width, 0.1), Transform((0.0, 0.0, -0.05)), colour)


def wheel_joint(alias: str, at: Vector, lag: float = 0.0) -> Joint:
    """Return a motor whose wheel's middle is at a place of its robot's body."""
    return Joint(alias, local=Transform(at, TO_THE_LEFT), control=JointMode.VELOCITY, lag=lag)
