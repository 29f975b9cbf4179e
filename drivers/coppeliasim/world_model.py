"""Build a world as objects of a scene: a floor, prisms and balls. None of them moves."""

from __future__ import annotations

from typing import NamedTuple

from drivers.coppeliasim.builder import NO_UNDO, CollisionMask, Placement, SceneBuilder, place_on_floor
from drivers.coppeliasim.restore import begin_building
from robotcore.description import Ball, Box, Cylinder, WorldDescription
from robotcore.geometry import Pose

GROUND_M, GROUND_DEPTH_M = 60.0, 0.1
"""The ground goes on beyond the world's floor; a vision sensor of ours sees no farther."""


class BuiltWorld(NamedTuple):
    """The handles of a world's objects: their root, and what can be touched."""

    root: int
    things: frozenset[int]
    seen: int
    """The collection of all, for cameras."""
    met: int
    """The collection of all but the floor, for range sensors."""


def build_world(builder: SceneBuilder, world: WorldDescription) -> BuiltWorld:
    """Make a world's objects, each under its own name; `finish` is to be called when all is built."""
    root = builder.dummy(world.name)
    builder.mark(root, NO_UNDO)
    begin_building(builder, root)
    floor = _add_floor(builder, world, root)
    builder.set_friction(floor, 1.0)
    prisms = [_add_prism(builder, prism, root) for prism in world.prisms]
    balls = [_add_ball(builder, ball, root) for ball in world.targets]
    seen, met = builder.collection(root), builder.collection(root, without=floor)
    return BuiltWorld(root, frozenset((*prisms, *balls)), seen, met)


def _add_floor(builder: SceneBuilder, world: WorldDescription, root: int) -> int:
    size = (GROUND_M, GROUND_M, GROUND_DEPTH_M)
    place = Placement(0.0, 0.0, -GROUND_DEPTH_M / 2)
    return builder.shape("cuboid", size, place, world.floor.colour, CollisionMask.FLOOR, "floor", root)


def _add_prism(builder: SceneBuilder, prism: Box | Cylinder, root: int) -> int:
    place = place_on_floor(Pose(prism.x_m, prism.y_m, prism.yaw_rad))._replace(z=prism.height_m / 2)
    if isinstance(prism, Box):
        kind, across = "cuboid", (prism.length_m, prism.width_m)
    else:
        kind, across = "cylinder", (2 * prism.radius_m, 2 * prism.radius_m)
    return builder.shape(kind, (*across, prism.height_m), place, prism.colour, CollisionMask.THING, prism.name, root)


def _add_ball(builder: SceneBuilder, ball: Ball, root: int) -> int:
    size = (2 * ball.radius_m,) * 3
    place = Placement(ball.x_m, ball.y_m, ball.radius_m)
    return builder.shape("spheroid", size, place, ball.colour, CollisionMask.THING, ball.name, root)
