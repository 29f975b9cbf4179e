"""Whether the things of a world have room beside each other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from robotcore.description.faults import Fault, limit_errors
from robotcore.description.gaps import gap_between, gap_to_edge
from robotcore.description.robot import RobotDescription
from robotcore.description.world import Ball, Box, Cylinder, Outline, WorldDescription, round_outline
from robotcore.errors import DescriptionError

Thing = Box | Cylinder | Ball
START_POINT_M = 0.01
"""How much of the floor a start takes while nobody knows the robot."""


def require_room(world: WorldDescription, file: str) -> None:
    """Raise DescriptionError where things of a world, as it is written, are in each other; it tells all of them.

    Obstacles may overlap each other, and reach into a wall: so an L or an alcove is built.
    """
    if faults := limit_errors(_faults(world)):
        raise DescriptionError.of_all(file, faults)


def require_start(world: WorldDescription, robot: RobotDescription, file: str | None = None) -> None:
    """Raise DescriptionError where the robot, at the start, would stand in something or beyond a wall."""
    outline = tuple(world.start.pose.to_world(x, y) for x, y in robot.body.footprint)
    if faults := list(_faults_of_start(world, _Outlines(world), outline, f"the robot {robot.name!r}")):
        raise DescriptionError.of_all(file or f"the world {world.name!r}", faults)


class _Outlines:
    """The outlines of a world's things, and the boxes around them: most things are too far apart to look closer."""

    def __init__(self, world: WorldDescription) -> None:
        self._outlined = [(thing, thing.outline) for thing in world.things]
        corners = [np.array(outline) for _, outline in self._outlined]
        self._lows = np.array([each.min(axis=0) for each in corners]).reshape(-1, 2)
        self._highs = np.array([each.max(axis=0) for each in corners]).reshape(-1, 2)

    def overlapping(self, outline: Outline, first: int | None = None) -> Iterator[Thing]:
        """Yield which things, of the ``first`` ones or of all, an outline is in."""
        low, high = np.min(outline, axis=0), np.max(outline, axis=0)
        is_near = (self._lows[:first] <= high).all(axis=1) & (self._highs[:first] >= low).all(axis=1)
        for index in np.flatnonzero(is_near):
            thing, other = self._outlined[index]
            if gap_between(outline, other) < 0:
                yield thing


def _faults(world: WorldDescription) -> Iterator[Fault]:
    outlines = _Outlines(world)
    for obstacle in world.obstacles:
        middle, key = ((obstacle.x_m, obstacle.y_m),), f"obstacles[{obstacle.name}]"
        yield from _beyond_walls(world, middle, key, "its middle")
    for number, ball in enumerate(world.targets, len(world.obstacles)):
        key = f"targets[{ball.name}]"
        yield from _beyond_walls(world, ball.outline, key, "it")
        yield from _overlaps(outlines.overlapping(ball.outline, number), key, "it")
    start = round_outline(world.start.x_m, world.start.y_m, START_POINT_M)
    yield from _faults_of_start(world, outlines, start, "it")


def _faults_of_start(world: WorldDescription, outlines: _Outlines, outline: Outline, who: str) -> Iterator[Fault]:
    yield from _beyond_walls(world, outline, "start", who)
    yield from _overlaps(outlines.overlapping(outline), "start", who)


def _beyond_walls(world: WorldDescription, outline: Outline, key: str, who: str) -> Iterator[Fault]:
    if world.walls and gap_to_edge(outline, world.floor) < 0:
        x, y = world.floor.length_m / 2, world.floor.width_m / 2
        remedy = f"The walls are at x = ±{x:g} m and y = ±{y:g} m: move it in between"
        yield Fault(key, f"{who} is in or beyond a wall", remedy)


def _overlaps(things: Iterable[Thing], key: str, who: str) -> Iterator[Fault]:
    for thing in things:
        kind = "target" if isinstance(thing, Ball) else "obstacle"
        yield Fault(key, f"{who} is in the {kind} {thing.name!r}", "Move either so that they are apart")
