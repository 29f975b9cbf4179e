"""Whether the things of a world have room beside each other."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

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
        if world.walls and gap_to_edge(((obstacle.x_m, obstacle.y_m),), world.floor) < 0:
            raise _outside(world, file, f"obstacles[{obstacle.name}]")
    for ball in world.targets:
        if world.walls and gap_to_edge(ball.outline, world.floor) < 0:
            raise _outside(world, file, f"targets[{ball.name}]")
        for other in world.obstacles:
            _require_apart(file, f"targets[{ball.name}]", ball.outline, other)
    for one, other in combinations(world.targets, 2):
        _require_apart(file, f"targets[{one.name}]", one.outline, other)
    _require_start(world, round_outline(world.start.x_m, world.start.y_m, START_POINT_M), file)


def require_start(world: WorldDescription, robot: RobotDescription, file: str | None = None) -> None:
    """Raise DescriptionError where the robot, at the start, would stand in something or outside the walls."""
    outline = tuple(world.start.pose.to_world(x, y) for x, y in robot.body.footprint)
    _require_start(world, outline, file or f"the world {world.name!r}", f", with the robot {robot.name!r} there")


def things_of(world: WorldDescription) -> Iterator[Thing]:
    """Yield what stands or lies on the floor: obstacles, then targets."""
    yield from world.obstacles
    yield from world.targets


def _require_start(world: WorldDescription, outline: Outline, file: str, who: str = "") -> None:
    if world.walls and gap_to_edge(outline, world.floor) < 0:
        raise _outside(world, file, "start", who)
    for thing in things_of(world):
        _require_apart(file, "start", outline, thing, who)


def _require_apart(file: str, key: str, outline: Outline, thing: Thing, who: str = "") -> None:
    if gap_between(outline, thing.outline) < 0:
        kind = "target" if isinstance(thing, Ball) else "obstacle"
        raise DescriptionError(
            file, key, f"it is in the {kind} {thing.name!r}{who}", "Move either so that they are apart"
        )


def _outside(world: WorldDescription, file: str, key: str, who: str = "") -> DescriptionError:
    half_x, half_y = world.floor.length_m / 2, world.floor.width_m / 2
    return DescriptionError(
        file,
        key,
        f"it reaches into or beyond a wall{who}",
        f"The walls stand at x = ±{half_x:g} m and y = ±{half_y:g} m: move it in between",
    )
