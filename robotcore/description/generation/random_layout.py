"""Draws the layout of a world from a seed: the poses of targets, obstacles and the robot."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from random import Random
from typing import Any, NamedTuple

from robotcore.description.conditions import Light
from robotcore.description.generation.gaps import gap_to_edge, has_gap
from robotcore.description.generation.reachability import is_solvable, is_target_hidden, is_target_in_view
from robotcore.description.robot import RobotDescription
from robotcore.description.world import Ball, Box, Cylinder, Outline, Start, Variation, WorldDescription, round_outline
from robotcore.errors import DescriptionError, UsageError


class Constraint(NamedTuple):
    """A constraint on a drawn world, and the error message for a world in which no drawn layout meets it."""

    number: int
    """The place in the order in which the constraints are checked."""
    kind: str
    """The kind of the error."""
    key: str
    """The key in the world's file that the user can change."""
    problem: str
    remedy: str


_MORE_ROOM = "Take fewer or smaller obstacles, a smaller gap_m, or wider place_x_m and place_y_m"
OBSTACLE_ROOM = Constraint(1, "no-obstacle-room", "variation.gap_m", "there is no room for the obstacles", _MORE_ROOM)
START_ROOM = Constraint(
    2,
    "no-start-room",
    "variation.place_x_m",
    "there is no start with room for the robot to turn",
    "Take fewer or smaller obstacles, or wider place_x_m and place_y_m",
)
TARGET_ROOM = Constraint(3, "no-target-room", "variation.gap_m", "there is no room for a target", _MORE_ROOM)
TARGET_DISTANCE = Constraint(
    4,
    "no-target-distance",
    "variation.target_distance_m",
    "no position of the target is within target_distance_m from the start",
    "Widen target_distance_m, or place_x_m and place_y_m",
)
TARGET_HIDDEN = Constraint(
    5,
    "no-target-hidden",
    "variation.target_hidden",
    "every position of the target is visible from the start",
    "Take more or larger obstacles, higher than camera and target, or set target_hidden = false",
)
TARGET_IN_VIEW = Constraint(
    6,
    "no-target-in-view",
    "variation.target_distance_m",
    "the robot cannot drive, and no position of the target is in view of its camera",
    "Take fewer obstacles, another target_distance_m, or another mount of the camera",
)
PATH = Constraint(
    7,
    "no-path",
    "variation.gap_m",
    "there is no path to the target",
    "Take a larger gap_m, or fewer or smaller obstacles",
)

MAX_LAYOUTS = 100
"""The greatest number of layouts that are drawn for a seed until one meets all constraints."""

MAX_POSITIONS = 40
"""The greatest number of positions that are drawn for a body in a layout."""

PASSING_MARGIN_M = 0.025
"""The least gap, in metres, on each side of a robot that turns on the spot between two bodies."""

TURNING_MARGIN_M = 0.05
"""The least gap, in metres, around a robot that turns on the spot at the start."""

PlacementStep = Callable[[WorldDescription], "WorldDescription | None"]


def draw_world(world: WorldDescription, robot: RobotDescription, seed: int) -> WorldDescription:
    """Return a world with a layout drawn from a seed. Equal arguments always give the same layout.

    The robot can then turn at the start, pass between any two bodies, and reach the first target. A robot that cannot
    drive starts with the first target in view. For a world without ``variation``, positions and headings are drawn from
    the whole floor.

    world: the world as its file describes it.
    robot: the robot that will run in the world.
    seed: the seed, 0 or more.

    Raises UsageError for a negative seed, and DescriptionError if no layout meets the constraints.

    >>> from robotcore.description import load_robot, load_world
    >>> arena, rover = load_world("arena"), load_robot("rover")
    >>> drawn = draw_world(arena, rover, seed=7)
    >>> drawn == draw_world(arena, rover, seed=7), drawn == draw_world(arena, rover, seed=8)
    (True, False)
    """
    if seed < 0:
        raise UsageError(f"the seed is {seed}; take 0 or more", kind="negative-seed", seed=seed)
    drawing = _LayoutDrawing(world, robot, Random(seed).random)
    for _ in range(MAX_LAYOUTS):
        if drawn := drawing.draw():
            return drawn
    _, kind, key, problem, remedy = drawing.last_failed
    size = f"{robot.body.length_m:g} m x {robot.body.width_m:g} m"
    problem = f"{problem} (seed {seed}, robot {robot.name!r} of {size})"
    raise DescriptionError(f"the world {world.name!r}", key, problem, remedy, kind=kind, seed=seed)


class _LayoutDrawing:
    """Draws layouts for a seed.

    ``last_failed`` is the last of the constraints that a drawn layout did not meet.
    """

    def __init__(self, world: WorldDescription, robot: RobotDescription, random: Callable[[], float]) -> None:
        self._world, self._robot, self._random = world, robot, random
        self._variation = world.variation or _make_variation(world)
        self._gap = _least_gap(self._variation, robot)
        self.last_failed = OBSTACLE_ROOM

    def draw(self) -> WorldDescription | None:
        """Draw a layout. Return the world with the layout, or None if the layout does not meet all constraints."""
        drawn = self._world.model_copy(update={"light": self._draw_light()})
        if _moves_bodies(self._variation):
            drawn = drawn.model_copy(update={"obstacles": (), "targets": ()})
            for step in self._steps():
                placed = next(filter(None, (step(drawn) for _ in range(MAX_POSITIONS))), None)
                if placed is None:
                    return None
                drawn = placed
        return drawn if self._check(PATH, is_met=is_solvable(drawn, self._robot)) else None

    def _steps(self) -> Iterator[PlacementStep]:
        # Each step adds a body at a drawn position, or returns None if there is no room.
        for obstacle in self._world.obstacles:
            yield partial(self._add_obstacle, obstacle)
        yield self._set_start
        for target in self._world.targets:
            yield partial(self._add_target, target)

    def _add_obstacle(self, obstacle: Box | Cylinder, world: WorldDescription) -> WorldDescription | None:
        update = {**self._draw_position(obstacle), "yaw_rad": self._draw_yaw(obstacle), **self._draw_size(obstacle)}
        placed = obstacle.model_copy(update=update)
        if not self._check(OBSTACLE_ROOM, is_met=_has_room(placed.outline, world, self._gap)):
            return None
        return world.model_copy(update={"obstacles": (*world.obstacles, placed)})

    def _set_start(self, world: WorldDescription) -> WorldDescription | None:
        update = {**self._draw_position(world.start), "yaw_rad": self._draw_yaw(world.start)}
        start = world.start.model_copy(update=update)
        if not self._check(START_ROOM, is_met=_has_room(self._disc(start), world, TURNING_MARGIN_M)):
            return None
        return world.model_copy(update={"start": start})

    def _add_target(self, target: Ball, world: WorldDescription) -> WorldDescription | None:
        ball = target.model_copy(update=self._draw_position(target))
        is_apart = has_gap(self._disc(world.start), ball.outline, TURNING_MARGIN_M)
        if not self._check(TARGET_ROOM, is_met=is_apart and _has_room(ball.outline, world, self._gap)):
            return None
        drawn = world.model_copy(update={"targets": (*world.targets, ball)})
        if world.targets:
            return drawn
        drawn = self._face_target(drawn, ball)
        return drawn if self._check_target(drawn, ball) else None

    def _check_target(self, world: WorldDescription, ball: Ball) -> bool:
        nearest, farthest = self._variation.target_distance_m or (0.0, math.inf)
        distance = world.start.pose.distance_to(ball.x_m, ball.y_m)
        if not self._check(TARGET_DISTANCE, is_met=nearest <= distance <= farthest):
            return False
        if self._fixed_camera:
            return self._check(TARGET_IN_VIEW, is_met=is_target_in_view(world, self._robot))
        is_met = not self._variation.target_hidden or is_target_hidden(world, self._robot)
        return self._check(TARGET_HIDDEN, is_met=is_met)

    def _face_target(self, world: WorldDescription, ball: Ball) -> WorldDescription:
        # A robot that cannot drive starts with the ball in view.
        if (camera := self._fixed_camera) is None:
            return world
        aside = (self._random() - 0.5) * camera.horizontal_fov_rad
        turn = world.start.pose.bearing_to(ball.x_m, ball.y_m) - camera.mount.yaw_rad + aside
        start = world.start.model_copy(update={"yaw_rad": world.start.yaw_rad + turn})
        return world.model_copy(update={"start": start})

    @property
    def _fixed_camera(self) -> Any:
        """The camera of a robot that cannot drive; None for a robot that can drive."""
        return None if self._robot.drive else self._robot.first_of("camera")

    def _disc(self, start: Start) -> Outline:
        # The part of the floor that the robot covers as it turns on the spot.
        return round_outline(start.x_m, start.y_m, self._robot.body.reach_m)

    def _check(self, constraint: Constraint, *, is_met: bool) -> bool:
        if not is_met:
            self.last_failed = max(self.last_failed, constraint)
        return is_met

    def _draw_light(self) -> Light:
        light, variation = self._world.light, self._variation
        return light.model_copy(
            update={
                "azimuth_rad": self._draw(variation.light_azimuth_rad, light.azimuth_rad),
                "elevation_rad": self._draw(variation.light_elevation_rad, light.elevation_rad),
                "brightness": self._draw(variation.light_brightness, light.brightness),
            }
        )

    def _draw_position(self, body: Box | Cylinder | Ball | Start) -> dict[str, float]:
        return {
            "x_m": self._draw(self._variation.place_x_m, body.x_m),
            "y_m": self._draw(self._variation.place_y_m, body.y_m),
        }

    def _draw_yaw(self, body: Box | Cylinder | Start) -> float:
        return self._draw(self._variation.yaw_rad, body.yaw_rad)

    def _draw_size(self, obstacle: Box | Cylinder) -> dict[str, float]:
        # The height is not scaled, so that sensors still detect the obstacle.
        scale = self._draw(self._variation.obstacle_scale, 1.0)
        if isinstance(obstacle, Cylinder):
            return {"radius_m": obstacle.radius_m * scale}
        return {"length_m": obstacle.length_m * scale, "width_m": obstacle.width_m * scale}

    def _draw(self, interval: tuple[float, float] | None, written: float) -> float:
        if interval is None:
            return written
        low, high = interval
        return low + (high - low) * self._random()


def _make_variation(world: WorldDescription) -> Variation:
    # Any position on the floor and any heading.
    half_x, half_y = world.floor.length_m / 2, world.floor.width_m / 2
    return Variation(place_x_m=(-half_x, half_x), place_y_m=(-half_y, half_y), yaw_rad=(-math.pi, math.pi))


def _moves_bodies(variation: Variation) -> bool:
    # The other variations change only the light.
    moves = variation.place_x_m or variation.place_y_m or variation.yaw_rad
    return moves is not None or variation.obstacle_scale != (1.0, 1.0)


def _least_gap(variation: Variation, robot: RobotDescription) -> float:
    passage = 2 * (robot.body.reach_m + PASSING_MARGIN_M) if robot.drive else 0.0
    return max(variation.gap_m, passage)


def _has_room(outline: Outline, world: WorldDescription, gap: float) -> bool:
    from_edge = gap if world.walls else 0.0
    return gap_to_edge(outline, world.floor) >= from_edge and all(
        has_gap(outline, body.outline, gap) for body in world.bodies
    )
