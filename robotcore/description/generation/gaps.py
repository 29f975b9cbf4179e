"""Computes the gaps between bodies on the floor, and reports bodies that overlap."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from robotcore.description.robot import RobotDescription
from robotcore.description.validation import limit_errors
from robotcore.description.world import Ball, Box, Cylinder, Floor, Outline, WorldDescription, round_outline
from robotcore.errors import DescriptionError, Mistake

Array = NDArray[np.float64]

ROUNDING_M = 1e-9
"""A greater gap than the required one by this length, in metres, is no matter of rounding."""


def compute_gap(one: Outline, other: Outline) -> float:
    """Return the gap between two convex outlines in metres. It is negative if they overlap.

    If the nearest points are two corners, the result is smaller than their distance. The method is that of separating
    axes. Source: Ericson, Real-Time Collision Detection, 5.2.1.

    >>> square = ((1.0, 1.0), (0.0, 1.0), (0.0, 0.0), (1.0, 0.0))
    >>> compute_gap(square, tuple((x + 1.5, y) for x, y in square))
    0.5
    """
    a, b = np.array(one), np.array(other)
    return max(_largest_gap(a, b), _largest_gap(b, a))


def has_gap(one: Outline, other: Outline, gap: float) -> bool:
    """Return whether `compute_gap` of two bodies is at least ``gap``, in metres. It is faster for bodies far apart.

    The outlines are rectangles or regular polygons with an even number of sides.
    """
    (ax, ay, a), (bx, by, b) = _compute_circle(one), _compute_circle(other)
    # Among the normals of n sides, one differs from the way between the middles by at most π/n.
    nearest_normal = math.cos(math.pi / max(len(one), len(other)))
    is_far = math.hypot(bx - ax, by - ay) * nearest_normal - a - b > gap + ROUNDING_M
    return is_far or compute_gap(one, other) >= gap


def _compute_circle(outline: Outline) -> tuple[float, float, float]:
    """Return the middle and the radius of the circle through an outline's corners."""
    (x, y), (other_x, other_y) = outline[0], outline[len(outline) // 2]
    return (x + other_x) / 2, (y + other_y) / 2, math.hypot(other_x - x, other_y - y) / 2


def gap_to_edge(outline: Outline, floor: Floor) -> float:
    """Return the distance from an outline to the floor's edge in metres. It is negative if a corner is outside."""
    half = np.array((floor.length_m, floor.width_m)) / 2
    return float((half - np.abs(np.array(outline))).min())


def _largest_gap(outline: Array, corners: Array) -> float:
    dx, dy = (np.concatenate((outline[1:], outline[:1])) - outline).T
    normals = np.array((dy, -dx)) / np.hypot(dx, dy)
    offsets = (outline.T * normals).sum(axis=0)
    return float(((corners @ normals).min(axis=0) - offsets).max())


WorldBody = Box | Cylinder | Ball
START_POINT_M = 0.01
"""The radius, in metres, of the disc around the start that must be free in the file of a world."""


def require_room(world: WorldDescription, file: str) -> None:
    """Raise DescriptionError if a target or the start overlaps a body or a wall, or if a body is beyond a wall.

    The error lists all such mistakes. Obstacles may overlap each other and the walls.

    world: the world as its file describes it.
    file: the name of the file, for the message.
    """
    if mistakes := limit_errors(_find_mistakes(world)):
        raise DescriptionError.of_all(file, mistakes)


def require_start(world: WorldDescription, robot: RobotDescription, file: str | None = None) -> None:
    """Raise DescriptionError if the robot at the start overlaps a body or a wall.

    file: the name of the world's file, for the message.
    """
    outline = tuple(world.start.pose.to_world(x, y) for x, y in robot.body.footprint)
    if mistakes := list(_check_start(world, _Outlines(world), outline, f"the robot {robot.name!r}")):
        raise DescriptionError.of_all(file or f"the world {world.name!r}", mistakes)


class _Outlines:
    """The outlines of a world's bodies. A comparison of their bounding boxes makes `find_overlaps` fast."""

    def __init__(self, world: WorldDescription) -> None:
        self._outlines = [(body, body.outline) for body in world.bodies]
        corners = [np.array(outline) for _, outline in self._outlines]
        self._lows = np.array([each.min(axis=0) for each in corners]).reshape(-1, 2)
        self._highs = np.array([each.max(axis=0) for each in corners]).reshape(-1, 2)

    def find_overlaps(self, outline: Outline, first: int | None = None) -> Iterator[WorldBody]:
        """Yield the bodies that overlap an outline.

        first: the number of bodies to compare. None compares all bodies.
        """
        low, high = np.min(outline, axis=0), np.max(outline, axis=0)
        is_near = (self._lows[:first] <= high).all(axis=1) & (self._highs[:first] >= low).all(axis=1)
        for index in np.flatnonzero(is_near):
            body, other = self._outlines[index]
            if compute_gap(outline, other) < 0:
                yield body


def _find_mistakes(world: WorldDescription) -> Iterator[Mistake]:
    outlines = _Outlines(world)
    for obstacle in world.obstacles:
        middle, key = ((obstacle.x_m, obstacle.y_m),), f"obstacles[{obstacle.name}]"
        yield from _check_walls(world, middle, key, "its middle")
    for number, ball in enumerate(world.targets, len(world.obstacles)):
        key = f"targets[{ball.name}]"
        yield from _check_walls(world, ball.outline, key, "it")
        yield from _check_overlaps(outlines.find_overlaps(ball.outline, number), key, "it")
    start = round_outline(world.start.x_m, world.start.y_m, START_POINT_M)
    yield from _check_start(world, outlines, start, "it")


def _check_start(world: WorldDescription, outlines: _Outlines, outline: Outline, subject: str) -> Iterator[Mistake]:
    yield from _check_walls(world, outline, "start", subject)
    yield from _check_overlaps(outlines.find_overlaps(outline), "start", subject)


def _check_walls(world: WorldDescription, outline: Outline, key: str, subject: str) -> Iterator[Mistake]:
    if world.walls and gap_to_edge(outline, world.floor) < 0:
        x, y = world.floor.length_m / 2, world.floor.width_m / 2
        remedy = f"Move it between the walls, which are at x = ±{x:g} m and y = ±{y:g} m"
        yield Mistake(f"{subject} is in or beyond a wall", remedy, kind="beyond-wall", key=key)


def _check_overlaps(bodies: Iterable[WorldBody], key: str, subject: str) -> Iterator[Mistake]:
    for body in bodies:
        kind = "target" if isinstance(body, Ball) else "obstacle"
        problem = f"{subject} overlaps the {kind} {body.name!r}"
        yield Mistake(problem, "Move one of the two", kind=f"in-{kind}", key=key)
