"""Where the robot of a recording went."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise

from robotcore.geometry import Pose
from robotcore.recording.recording import Recording

Path = dict[int, Pose]
"""Poses in the world by the numbers of their ticks; without a world, seen from where the robot began."""


_MOST_M = 1e6
"""No robot goes farther: a pose beyond it comes of a number that is none, such as an encoder's."""


def odometry_path(recording: Recording) -> Path:
    """Return where the wheels took the robot, as the app knew it; empty without a drive."""
    world = recording.metadata.world
    start = world.start.pose if world else Pose(0.0, 0.0, 0.0)
    return {tick.number: start.moved(tick.pose) for tick in recording.ticks if tick.pose and _is_place(tick.pose)}


def true_path(recording: Recording) -> Path:
    """Return where the robot was by the simulator's word; empty where there is none."""
    return {glimpse.tick: glimpse.pose for glimpse in recording.truth if _is_place(glimpse.pose)}


def _is_place(pose: Pose) -> bool:
    return max(abs(pose.x), abs(pose.y)) <= _MOST_M and math.isfinite(pose.heading) and not math.isnan(pose.x + pose.y)


def length_of(path: Iterable[Pose]) -> float:
    """Return how far it is along a path, in metres."""
    return sum(one.distance_to(other.x, other.y) for one, other in pairwise(path))
