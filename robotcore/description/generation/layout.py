"""Worlds drawn from a seed: where the ball, the obstacles and the robot stand."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from enum import IntEnum
from functools import partial
from random import Random
from typing import NamedTuple

from robotcore.description.conditions import Light
from robotcore.description.devices import CameraDescription
from robotcore.description.generation.clearance import gap_between, gap_to_edge
from robotcore.description.generation.reachability import is_solvable, is_target_hidden, is_target_in_view
from robotcore.description.robot import RobotDescription
from robotcore.description.world import Ball, Box, Cylinder, Outline, Start, Variation, WorldDescription, round_outline
from robotcore.errors import DescriptionError, UsageError


class Constraint(IntEnum):
    """What a drawn world must pass, in the order in which it is looked at."""

    OBSTACLE_ROOM = 1
    START_ROOM = 2
    TARGET_ROOM = 3
    TARGET_DISTANCE = 4
    TARGET_HIDDEN = 5
    TARGET_IN_VIEW = 6
    PATH = 7

    @property
    def advice(self) -> Advice:
        """What to say where it is never passed."""
        return _ADVICE[self]


class Advice(NamedTuple):
    """The key of the world's file, the fault, and what to loosen."""

    key: str
    fault: str
    remedy: str


_ADVICE = {
    Constraint.OBSTACLE_ROOM: Advice(
        "variation.gap_m",
        "the obstacles find no room",
        "Take fewer or smaller ones, a smaller gap_m, or wider place_x_m and place_y_m",
    ),
    Constraint.START_ROOM: Advice(
        "variation.place_x_m",
        "the robot finds no place to start from with room to turn",
        "Take fewer or smaller obstacles, or wider place_x_m and place_y_m",
    ),
    Constraint.TARGET_ROOM: Advice(
        "variation.gap_m",
        "a target finds no room",
        "Take fewer or smaller obstacles, a smaller gap_m, or wider place_x_m and place_y_m",
    ),
    Constraint.TARGET_DISTANCE: Advice(
        "variation.target_distance_m",
        "the target comes nowhere so far from the start",
        "Widen target_distance_m, or place_x_m and place_y_m",
    ),
    Constraint.TARGET_HIDDEN: Advice(
        "variation.target_hidden",
        "the target is in sight wherever it is placed",
        "Take more or larger obstacles, higher than camera and target, or set target_hidden = false",
    ),
    Constraint.TARGET_IN_VIEW: Advice(
        "variation.target_distance_m",
        "a robot that cannot drive never has the target in its picture",
        "Take fewer obstacles, another target_distance_m, or another mount of the camera",
    ),
    Constraint.PATH: Advice(
        "variation.gap_m",
        "the robot finds no way to the target",
        "Take a larger gap_m, or fewer or smaller obstacles",
    ),
}


ATTEMPTS = 100
TRIES = 40
"""How often each thing is placed anew before an attempt is given up."""

PASSING_MARGIN_M = 0.025
"""On either side of a robot that drives, turned whichever way, between two things."""

TURNING_MARGIN_M = 0.05
"""Around a robot that turns on the spot where it starts."""

Step = Callable[[WorldDescription], "WorldDescription | None"]


def draw_world(world: WorldDescription, robot: RobotDescription, seed: int) -> WorldDescription:
    """Return the variation of a world that belongs to a seed: always the same for one world and one robot.

    The robot can turn at the start, passes between any two things, and finds a way to the first target. One
    that cannot drive starts with the target in its picture instead. Without ``variation`` everything is placed
    anew, all over the floor. Raises DescriptionError where nothing is found that keeps to the variation.
    """
    if seed < 0:
        raise UsageError(f"the seed is {seed}; take 0 or more")
    drawing = _LayoutDrawing(world, robot, Random(seed).random)
    for _ in range(ATTEMPTS):
        if drawn := drawing.attempt():
            return drawn
    key, fault, remedy = drawing.highest.advice
    raise DescriptionError(f"the world {world.name!r}", key, f"{fault} (seed {seed})", remedy)


class _LayoutDrawing:
    """The draws of one seed; ``highest`` is the hurdle farthest on that any of them did not pass."""

    def __init__(self, world: WorldDescription, robot: RobotDescription, random: Callable[[], float]) -> None:
        self._world, self._robot, self._random = world, robot, random
        self._variation = world.variation or _all_over(world)
        self._gap = _gap(self._variation, robot)
        self.highest = Constraint.OBSTACLE_ROOM

    def attempt(self) -> WorldDescription | None:
        """Return a world that passes every hurdle; None where this attempt did not come to one."""
        drawn = self._world.model_copy(update={"light": self._light()})
        if _places(self._variation):
            drawn = drawn.model_copy(update={"obstacles": (), "targets": ()})
            for step in self._steps():
                placed = next(filter(None, (step(drawn) for _ in range(TRIES))), None)
                if placed is None:
                    return None
                drawn = placed
        return drawn if self._passes(Constraint.PATH, when=is_solvable(drawn, self._robot)) else None

    def _steps(self) -> Iterator[Step]:
        """Yield what adds one thing to a world at a place just drawn, or finds that it does not fit there."""
        for obstacle in self._world.obstacles:
            yield partial(self._with_obstacle, obstacle)
        yield self._with_start
        for target in self._world.targets:
            yield partial(self._with_target, target)

    def _with_obstacle(self, obstacle: Box | Cylinder, world: WorldDescription) -> WorldDescription | None:
        update = {**self._place(obstacle), "yaw_rad": self._yaw(obstacle), **self._size(obstacle)}
        placed = obstacle.model_copy(update=update)
        if not self._passes(Constraint.OBSTACLE_ROOM, when=_has_room(placed.outline, world, self._gap)):
            return None
        return world.model_copy(update={"obstacles": (*world.obstacles, placed)})

    def _with_start(self, world: WorldDescription) -> WorldDescription | None:
        start = world.start.model_copy(update={**self._place(world.start), "yaw_rad": self._yaw(world.start)})
        if not self._passes(Constraint.START_ROOM, when=_has_room(self._disc(start), world, TURNING_MARGIN_M)):
            return None
        return world.model_copy(update={"start": start})

    def _with_target(self, target: Ball, world: WorldDescription) -> WorldDescription | None:
        ball = target.model_copy(update=self._place(target))
        is_apart = gap_between(self._disc(world.start), ball.outline) >= TURNING_MARGIN_M
        if not self._passes(Constraint.TARGET_ROOM, when=is_apart and _has_room(ball.outline, world, self._gap)):
            return None
        drawn = world.model_copy(update={"targets": (*world.targets, ball)})
        if world.targets:
            return drawn
        drawn = self._facing_target(drawn, ball)
        return drawn if self._is_as_seen(drawn, ball) else None

    def _is_as_seen(self, world: WorldDescription, ball: Ball) -> bool:
        """Whether the first target is as far away, and as hidden or in view, as it is to be."""
        nearest, farthest = self._variation.target_distance_m or (0.0, math.inf)
        distance = world.start.pose.distance_to(ball.x_m, ball.y_m)
        if not self._passes(Constraint.TARGET_DISTANCE, when=nearest <= distance <= farthest):
            return False
        if self._watcher:
            return self._passes(Constraint.TARGET_IN_VIEW, when=is_target_in_view(world, self._robot))
        is_right = not self._variation.target_hidden or is_target_hidden(world, self._robot)
        return self._passes(Constraint.TARGET_HIDDEN, when=is_right)

    def _facing_target(self, world: WorldDescription, ball: Ball) -> WorldDescription:
        """Return the world with a robot that cannot drive turned so that it looks about where the ball is."""
        if (camera := self._watcher) is None:
            return world
        aside = (self._random() - 0.5) * camera.horizontal_fov_rad
        turn = world.start.pose.bearing_to(ball.x_m, ball.y_m) - camera.mount.yaw_rad + aside
        start = world.start.model_copy(update={"yaw_rad": world.start.yaw_rad + turn})
        return world.model_copy(update={"start": start})

    @property
    def _watcher(self) -> CameraDescription | None:
        """The camera of a robot that cannot drive."""
        return None if self._robot.drive else self._robot.first_of(CameraDescription)

    def _disc(self, start: Start) -> Outline:
        """What the robot covers when it turns on the spot."""
        return round_outline(start.x_m, start.y_m, self._robot.body.reach_m)

    def _passes(self, hurdle: Constraint, *, when: bool) -> bool:
        if not when:
            self.highest = max(self.highest, hurdle)
        return when

    def _light(self) -> Light:
        light, variation = self._world.light, self._variation
        return light.model_copy(
            update={
                "azimuth_rad": self._drawn(variation.light_azimuth_rad, light.azimuth_rad),
                "elevation_rad": self._drawn(variation.light_elevation_rad, light.elevation_rad),
                "brightness": self._drawn(variation.light_brightness, light.brightness),
            }
        )

    def _place(self, thing: Box | Cylinder | Ball | Start) -> dict[str, float]:
        return {
            "x_m": self._drawn(self._variation.place_x_m, thing.x_m),
            "y_m": self._drawn(self._variation.place_y_m, thing.y_m),
        }

    def _yaw(self, thing: Box | Cylinder | Start) -> float:
        return self._drawn(self._variation.yaw_rad, thing.yaw_rad)

    def _size(self, obstacle: Box | Cylinder) -> dict[str, float]:
        """Its outline is scaled, its height is kept: so sensors still meet it."""
        scale = self._drawn(self._variation.obstacle_scale, 1.0)
        if isinstance(obstacle, Cylinder):
            return {"radius_m": obstacle.radius_m * scale}
        return {"length_m": obstacle.length_m * scale, "width_m": obstacle.width_m * scale}

    def _drawn(self, interval: tuple[float, float] | None, written: float) -> float:
        if interval is None:
            return written
        low, high = interval
        return low + (high - low) * self._random()


def _all_over(world: WorldDescription) -> Variation:
    """Return the variation of a world that has none: any place on its floor, any heading."""
    half_x, half_y = world.floor.length_m / 2, world.floor.width_m / 2
    return Variation(place_x_m=(-half_x, half_x), place_y_m=(-half_y, half_y), yaw_rad=(-math.pi, math.pi))


def _places(variation: Variation) -> bool:
    """Return whether things are placed anew, or only the light."""
    is_turned = variation.place_x_m or variation.place_y_m or variation.yaw_rad
    return is_turned is not None or variation.obstacle_scale != (1.0, 1.0)


def _gap(variation: Variation, robot: RobotDescription) -> float:
    """Return how far things are kept apart: at least so far that the robot passes."""
    passage = 2 * (robot.body.reach_m + PASSING_MARGIN_M) if robot.drive else 0.0
    return max(variation.gap_m, passage)


def _has_room(outline: Outline, world: WorldDescription, gap: float) -> bool:
    """Return whether an outline is on the floor and so far from walls and from what the world has by now."""
    from_edge = gap if world.walls else 0.0
    return gap_to_edge(outline, world.floor) >= from_edge and all(
        gap_between(outline, thing.outline) >= gap for thing in world.things
    )
