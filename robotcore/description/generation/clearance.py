"""Gaps between things on the floor, and mistakes of things that overlap."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from robotcore.description.robot import RobotDescription
from robotcore.description.validation import Mistake, limit_errors
from robotcore.description.world import Ball, Box, Cylinder, Floor, Outline, WorldDescription, round_outline
from robotcore.errors import DescriptionError

Array = NDArray[np.float64]


def gap_between(one: Outline, other: Outline) -> float:
    """Return how far apart two convex outlines are, in metres.

    Below zero where they overlap; never more than the true distance. By separating axes: Ericson, Real-Time
    Collision Detection, 5.2.1.
    """
    a, b = np.array(one), np.array(other)
    return max(_beyond_sides(a, b), _beyond_sides(b, a))


def gap_to_edge(outline: Outline, floor: Floor) -> float:
    """Return how far inside the floor's edge an outline lies, in metres; below zero where it stands out."""
    half = np.array((floor.length_m, floor.width_m)) / 2
    return float((half - np.abs(np.array(outline))).min())


def _beyond_sides(outline: Array, corners: Array) -> float:
    """Return how far all the corners lie beyond a counter-clockwise outline, by the best of its sides."""
    dx, dy = (np.concatenate((outline[1:], outline[:1])) - outline).T
    normals = np.array((dy, -dx)) / np.hypot(dx, dy)
    offsets = (outline.T * normals).sum(axis=0)
    return float(((corners @ normals).min(axis=0) - offsets).max())


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


def _faults(world: WorldDescription) -> Iterator[Mistake]:
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


def _faults_of_start(world: WorldDescription, outlines: _Outlines, outline: Outline, who: str) -> Iterator[Mistake]:
    yield from _beyond_walls(world, outline, "start", who)
    yield from _overlaps(outlines.overlapping(outline), "start", who)


def _beyond_walls(world: WorldDescription, outline: Outline, key: str, who: str) -> Iterator[Mistake]:
    if world.walls and gap_to_edge(outline, world.floor) < 0:
        x, y = world.floor.length_m / 2, world.floor.width_m / 2
        remedy = f"The walls are at x = ±{x:g} m and y = ±{y:g} m: move it in between"
        yield Mistake(key, f"{who} is in or beyond a wall", remedy)


def _overlaps(things: Iterable[Thing], key: str, who: str) -> Iterator[Mistake]:
    for thing in things:
        kind = "target" if isinstance(thing, Ball) else "obstacle"
        yield Mistake(key, f"{who} is in the {kind} {thing.name!r}", "Move either so that they are apart")
