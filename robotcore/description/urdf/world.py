"""A world's links: a floor, prisms and balls, all of them fixed."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree import ElementTree as ET

from robotcore.description.base import Colour
from robotcore.description.urdf.elements import ORIGIN, TOKEN, Shape, Vector, box, cylinder, joint, link, sphere
from robotcore.description.world import Ball, Box, Cylinder, WorldDescription

WORLD = "world"
"""The root: tools know by its name that it never moves."""

FLOOR = "floor"
GROUND_M = 100.0
"""The ground goes on beyond the floor's edge; a tool that puts a box there has to be told how far."""

_GROUND_DEPTH_M = 0.1


def world_parts(world: WorldDescription, robot: str, *, is_free: bool) -> Iterator[ET.Element]:
    """Yield all links and joints of a world, and the joint by which a robot's first link, ``robot``, is at its start.

    That one floats where the robot is free to move.
    """
    yield ET.Element("link", name=WORLD)
    ground = box(GROUND_M, GROUND_M, _GROUND_DEPTH_M, (0.0, 0.0, -_GROUND_DEPTH_M / 2))
    yield from _fixed(FLOOR, ground, world.floor.colour, ORIGIN, 0.0)
    for prism in world.prisms:
        yield from _fixed(
            _link_of(prism.name), _upright(prism), prism.colour, (prism.x_m, prism.y_m, 0.0), prism.yaw_rad
        )
    for ball in world.targets:
        yield from _fixed(_link_of(ball.name), sphere(ball.radius_m), ball.colour, _middle(ball), 0.0)
    start = world.start
    yield _place(robot, "floating" if is_free else "fixed", (start.x_m, start.y_m, 0.0), start.yaw_rad)


def _fixed(name: str, shape: Shape, rgb: Colour, xyz: Vector, yaw: float) -> Iterator[ET.Element]:
    yield link(name, TOKEN, shape, shape, rgb)
    yield _place(name, "fixed", xyz, yaw)


def _place(name: str, kind: str, xyz: Vector, yaw: float) -> ET.Element:
    return joint(f"{name}_place", kind, WORLD, name, xyz, (0.0, 0.0, yaw))


def _upright(prism: Box | Cylinder) -> Shape:
    """Return what stands on the floor. A cylinder is round here: the prism's corners are on it."""
    middle = (0.0, 0.0, prism.height_m / 2)
    if isinstance(prism, Box):
        return box(prism.length_m, prism.width_m, prism.height_m, middle)
    return cylinder(prism.radius_m, prism.height_m, middle)


def _middle(ball: Ball) -> Vector:
    return ball.x_m, ball.y_m, ball.radius_m


def _link_of(thing: str) -> str:
    """Return the name of a thing's link; no link of a robot's ends like it."""
    return f"{thing}_thing"
