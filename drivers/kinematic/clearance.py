"""Measure the gaps between the robot and other bodies, prevent overlaps and count contacts."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robotcore.description import WorldDescription
from robotcore.geometry import Pose
from robotcore.hal.truth import RELEASE_M
from robotcore.raycast import Outline, edges_of
from robotcore.simulation.painter.planes import Array, compute_half_planes, compute_run_starts, find_nearest_points


class CollisionChecker:
    """Decides whether the robot may move without overlapping a body, and counts contacts.

    A contact counts once, however long it lasts. To save time, the gaps are measured only if the robot may have
    travelled as far as the smallest gap since the last measurement.
    """

    def __init__(self, clearances: Clearance, start: Pose) -> None:
        self.contacts = 0
        self._clearances = clearances
        self._reach = clearances.reach
        self._touched: dict[int, float] = {}
        self._measure(clearances.measure_gaps(start))

    @property
    def touched(self) -> tuple[int, ...]:
        """The indices of the bodies that the robot touches now, the prisms and then the targets."""
        return tuple(self._touched)

    def try_move(self, here: Pose, there: Pose, distance: float, turn: float) -> bool:
        """Return whether the robot may move from the pose ``here`` to ``there``, and count a contact if not.

        A robot that overlaps a body may move out of it, but not deeper into it.

        distance: the length of the path in metres, 0 or more.
        turn: the change of the heading in radians, 0 or more.
        """
        travel = distance + turn * self._reach
        if self._travelled + travel < self._clearance:
            self._travelled += travel
            return True
        ahead = self._clearances.measure_gaps(there)
        is_hit = (ahead < 0) & (ahead < self._gaps)
        if not is_hit.any():
            self._measure(ahead)
            return True
        if self._travelled:
            self._measure(self._clearances.measure_gaps(here))
        self._touch(is_hit)
        return False

    def _measure(self, gaps: Array) -> None:
        self._gaps = gaps
        self._clearance = float(gaps.min(initial=np.inf))
        self._travelled = 0.0
        self._touched = {i: gap for i, gap in self._touched.items() if gaps[i] <= gap + RELEASE_M}

    def _touch(self, is_hit: NDArray[np.bool_]) -> None:
        for i in np.flatnonzero(is_hit).tolist():
            if i not in self._touched:
                self._touched[i] = float(self._gaps[i])
                self.contacts += 1


class Clearance:
    """Measures the horizontal gaps between a robot's convex footprint and the prisms and targets of a world."""

    def __init__(self, footprint: Outline, world: WorldDescription) -> None:
        outlines = [prism.outline for prism in world.prisms]
        self.reach = max(math.hypot(x, y) for x, y in footprint)
        """The distance from the robot's origin to the farthest corner of its footprint, in metres."""
        self._footprint = np.array(footprint)
        self._sides = edges_of([footprint])
        self._side_normals, self._side_offsets = compute_half_planes(self._sides)
        self._corners = np.array([corner for outline in outlines for corner in outline]).reshape(-1, 2)
        self._normals, self._offsets = compute_half_planes(edges_of(outlines))
        self._starts = compute_run_starts(map(len, outlines))
        self._centres = np.array([(ball.x_m, ball.y_m) for ball in world.targets]).reshape(-1, 2)
        self._radii = np.array([ball.radius_m for ball in world.targets])

    def measure_gaps(self, pose: Pose) -> Array:
        """Return the gap between the robot at ``pose`` and each body, as (n,) in metres; negative for an overlap.

        A gap may be smaller than the true distance, but its sign is exact.
        """
        cos, sin = math.cos(pose.heading), math.sin(pose.heading)
        to_world = np.array(((cos, sin), (-sin, cos)))
        place = np.array((pose.x, pose.y))
        body = self._footprint @ to_world + place
        corners = (self._corners - place) @ to_world.T
        centres = (self._centres - place) @ to_world.T
        return np.concatenate((self._gaps_to_prisms(body, corners), self._gaps_to_balls(centres)))

    def _gaps_to_prisms(self, body: Array, corners: Array) -> Array:
        """Return the gaps to the prisms by the separating axis theorem."""
        if not len(self._starts):
            return np.empty(0)
        past_things = (self._normals @ body.T).min(axis=1) - self._offsets
        past_body = corners @ self._side_normals.T - self._side_offsets
        by_things = np.maximum.reduceat(past_things, self._starts)
        by_body = np.minimum.reduceat(past_body, self._starts, axis=0).max(axis=1)
        return np.asarray(np.maximum(by_things, by_body))

    def _gaps_to_balls(self, centres: Array) -> Array:
        past_sides = (centres @ self._side_normals.T - self._side_offsets).max(axis=1)
        away = np.linalg.norm(centres[:, None] - find_nearest_points(self._sides, centres), axis=2).min(axis=1)
        gaps: Array = np.where(past_sides > 0, away, past_sides) - self._radii
        return gaps
