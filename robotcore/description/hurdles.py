"""What a drawn world must pass, and what to loosen where nothing passes."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple


class Hurdle(IntEnum):
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
    Hurdle.OBSTACLE_ROOM: Advice(
        "variation.gap_m",
        "the obstacles find no room",
        "Take fewer or smaller ones, a smaller gap_m, or wider place_x_m and place_y_m",
    ),
    Hurdle.START_ROOM: Advice(
        "variation.place_x_m",
        "the robot finds no place to start from with room to turn",
        "Take fewer or smaller obstacles, or wider place_x_m and place_y_m",
    ),
    Hurdle.TARGET_ROOM: Advice(
        "variation.gap_m",
        "a target finds no room",
        "Take fewer or smaller obstacles, a smaller gap_m, or wider place_x_m and place_y_m",
    ),
    Hurdle.TARGET_DISTANCE: Advice(
        "variation.target_distance_m",
        "the target comes nowhere so far from the start",
        "Widen target_distance_m, or place_x_m and place_y_m",
    ),
    Hurdle.TARGET_HIDDEN: Advice(
        "variation.target_hidden",
        "the target is in sight wherever it is placed",
        "Take more or larger obstacles, higher than camera and target, or set target_hidden = false",
    ),
    Hurdle.TARGET_IN_VIEW: Advice(
        "variation.target_distance_m",
        "a robot that cannot drive never has the target in its picture",
        "Take fewer obstacles, another target_distance_m, or another mount of the camera",
    ),
    Hurdle.PATH: Advice(
        "variation.gap_m",
        "the robot finds no way to the target",
        "Take a larger gap_m, or fewer or smaller obstacles",
    ),
}
