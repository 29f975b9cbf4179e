"""Whether the things of a world have room beside each other."""

from __future__ import annotations

from collections.abc import Iterable

from robotcore.description.gaps import gap_between, gap_to_edge
from robotcore.description.robot import RobotDescription
from robotcore.description.world import Ball, Box, Cylinder, Outline, WorldDescription, round_outline
from robotcore.errors import DescriptionError

Thing = Box | Cylinder | Ball
START_POINT_M = 0.01
"""How much of the floor a start takes while nobody knows the robot."""


def require_room(world: WorldDescription, file: str) -> None:
    """Raise DescriptionError where things of a world, as it is written, are in each other.

    Obstacles may overlap each other, and reach into a wall: so an L or an alcove is built.
    """
    for obstacle in world.obstacles:
        middle, key = ((obstacle.x_m, obstacle.y_m),), f"obstacles[{obstacle.name}]"
        _require_inside(world, middle, file, key, "its middle is in or beyond a wall")
    for number, ball in enumerate(world.targets):
        key = f"targets[{ball.name}]"
        _require_inside(world, ball.outline, file, key, "it is in or beyond a wall")
        _require_apart((*world.obstacles, *world.targets[:number]), ball.outline, file, key)
    _require_start(world, round_outline(world.start.x_m, world.start.y_m, START_POINT_M), file)


def require_start(world: WorldDescription, robot: RobotDescription, file: str | None = None) -> None:
    """Raise DescriptionError where the robot, at the start, would stand in something or beyond a wall."""
    outline = tuple(world.start.pose.to_world(x, y) for x, y in robot.body.footprint)
    _require_start(world, outline, file or f"the world {world.name!r}", f"the robot {robot.name!r}")


def _require_start(world: WorldDescription, outline: Outline, file: str, who: str = "it") -> None:
    _require_inside(world, outline, file, "start", f"{who} is in or beyond a wall")
    _require_apart(world.things, outline, file, "start", who)


def _require_inside(world: WorldDescription, outline: Outline, file: str, key: str, fault: str) -> None:
    if world.walls and gap_to_edge(outline, world.floor) < 0:
        x, y = world.floor.length_m / 2, world.floor.width_m / 2
        raise DescriptionError(file, key, fault, f"The walls are at x = ±{x:g} m and y = ±{y:g} m: move it in between")


def _require_apart(things: Iterable[Thing], outline: Outline, file: str, key: str, who: str = "it") -> None:
    for thing in things:
        if gap_between(outline, thing.outline) < 0:
            kind = "target" if isinstance(thing, Ball) else "obstacle"
            raise DescriptionError(
                file, key, f"{who} is in the {kind} {thing.name!r}", "Move either so that they are apart"
            )
