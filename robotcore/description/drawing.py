"""A world drawn anew from a seed: another start, other places, another light, and still a way to the target."""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import IntEnum
from random import Random
from typing import TypeVar

from robotcore.description.gaps import gap_between, gap_to_edge
from robotcore.description.passage import is_solvable
from robotcore.description.placement import things_of
from robotcore.description.robot import CameraDescription, RobotDescription
from robotcore.description.sight import is_target_hidden, is_target_in_view
from robotcore.description.world import (
    Ball,
    Box,
    Cylinder,
    Outline,
    Variation,
    WorldDescription,
    round_outline,
)
from robotcore.errors import DescriptionError, UsageError

ATTEMPTS = 100
TRIES = 40
"""How often each thing is placed anew before the whole attempt is given up."""

PASSING_MARGIN_M = 0.025
"""On either side of a robot that drives, turned whichever way, between two things."""

TURNING_MARGIN_M = 0.05
"""Around a robot that turns on the spot where it starts."""

Interval = tuple[float, float]
PlacedT = TypeVar("PlacedT", Box, Cylinder, Ball)


class Hurdle(IntEnum):
    """What a drawn world must pass, in this order."""

    OBSTACLE_ROOM = 1
    START_ROOM = 2
    TARGET_ROOM = 3
    TARGET_DISTANCE = 4
    TARGET_HIDDEN = 5
    TARGET_IN_VIEW = 6
    PATH = 7


ADVICE = {
    Hurdle.OBSTACLE_ROOM: (
        "gap_m",
        "the obstacles find no room",
        "Take fewer or smaller ones, a smaller gap_m, or wider place_x_m and place_y_m",
    ),
    Hurdle.START_ROOM: (
        "place_x_m",
        "the robot finds no room to start and turn",
        "Take fewer or smaller obstacles, or wider place_x_m and place_y_m",
    ),
    Hurdle.TARGET_ROOM: (
        "gap_m",
        "a target finds no room",
        "Take fewer or smaller obstacles, a smaller gap_m, or wider place_x_m and place_y_m",
    ),
    Hurdle.TARGET_DISTANCE: (
        "target_distance_m",
        "the target comes nowhere so far from the start",
        "Widen target_distance_m, or place_x_m and place_y_m",
    ),
    Hurdle.TARGET_HIDDEN: (
        "target_hidden",
        "the target is in sight wherever it is placed",
        "Take larger or more obstacles, higher than the camera and the target, or target_hidden = false",
    ),
    Hurdle.TARGET_IN_VIEW: (
        "target_distance_m",
        "a robot that cannot drive has the target nowhere in its picture",
        "Take fewer obstacles, another target_distance_m, or another mount of the camera",
    ),
    Hurdle.PATH: (
        "gap_m",
        "the robot finds no way to the target",
        "Take a larger gap_m, or fewer or smaller obstacles",
    ),
}
"""The key, the fault and the remedy where a hurdle is never passed."""


def draw_world(world: WorldDescription, robot: RobotDescription, seed: int) -> WorldDescription:
    """Return the variation of a world that belongs to a seed; the same for the same three.

    The robot has room to turn at the start, passes between any two things, and finds a way to the first target. A
    robot without a drive starts with the target in its picture. Without ``variation`` everything is placed anew, all
    over the floor. Raises DescriptionError where no world is found that keeps to the variation.
    """
    if seed < 0:
        raise UsageError(f"seed {seed} is below zero; take 0 or more")
    drawing = _Drawing(world, robot, Random(seed).random)
    for _ in range(ATTEMPTS):
        if drawn := drawing.attempt():
            return drawn
    key, fault, remedy = ADVICE[drawing.highest]
    raise DescriptionError(f"the world {world.name!r}", f"variation.{key}", f"{fault} (seed {seed})", remedy)


class _Drawing:
    """The draws of one seed; ``highest`` is the last hurdle that any of them came to and did not pass."""

    def __init__(
        self, world: WorldDescription, robot: RobotDescription, random: Callable[[], float]
    ) -> None:
        self._world, self._robot, self._random = world, robot, random
        self._variation = world.variation or _all_over(world)
        self.highest = Hurdle.OBSTACLE_ROOM

    def attempt(self) -> WorldDescription | None:
        """Return a world that passes every hurdle; None where this attempt did not come to one."""
        drawn: WorldDescription | None = self._emptied()
        for obstacle in self._world.obstacles:
            drawn = drawn and self._with_obstacle(drawn, obstacle)
        drawn = drawn and self._with_start(drawn)
        for target in self._world.targets:
            drawn = drawn and self._with_target(drawn, target)
        return drawn if drawn and self._passes(Hurdle.PATH, is_solvable(drawn, self._robot)) else None

    def _emptied(self) -> WorldDescription:
        light, variation = self._world.light, self._variation
        update = {
            "azimuth_rad": self._from(variation.light_azimuth_rad, light.azimuth_rad),
            "elevation_rad": self._from(variation.light_elevation_rad, light.elevation_rad),
            "brightness": self._from(variation.light_brightness, light.brightness),
        }
        lit = light.model_copy(update=update)
        return self._world.model_copy(update={"light": lit, "obstacles": (), "targets": ()})

    def _with_obstacle(
        self, world: WorldDescription, obstacle: Box | Cylinder
    ) -> WorldDescription | None:
        for _ in range(TRIES):
            placed = self._scaled(self._placed(obstacle))
            placed = placed.model_copy(update={"yaw_rad": self._from(self._variation.yaw_rad, obstacle.yaw_rad)})
            if self._passes(Hurdle.OBSTACLE_ROOM, _has_room(placed.outline, world, self._gap)):
                return world.model_copy(update={"obstacles": (*world.obstacles, placed)})
        return None

    def _with_start(self, world: WorldDescription) -> WorldDescription | None:
        for _ in range(TRIES):
            update = {**self._place(world.start), "yaw_rad": self._from(self._variation.yaw_rad, world.start.yaw_rad)}
            start = world.start.model_copy(update=update)
            disc = round_outline(start.x_m, start.y_m, self._robot.body.reach_m)
            if self._passes(Hurdle.START_ROOM, _has_room(disc, world, TURNING_MARGIN_M)):
                return world.model_copy(update={"start": start})
        return None
