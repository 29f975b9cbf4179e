"""Who touches whom: wheels and casters the floor, a robot's body what it drove against."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drivers.kinematic.clearance import Bumper, Clearance
from robotcore.geometry import Pose
from robotcore.raycast import edges_of
from robotcore.simulation.painter.planes import Array, nearest_on
from tests.doubles.coppeliasim.scene.poses import Vector

Outline = Sequence[tuple[float, float]]

GRAVITY_M_S2 = 9.81


class Contact(NamedTuple):
    """Two shapes by handle, where they touch, and the force and the normal, both towards ``first``; m and N."""

    first: int
    second: int
    point: Vector
    force: Vector
    normal: Vector

    @classmethod
    def of(cls, first: int, second: int, point: Vector, normal: Vector, force: float) -> Contact:
        x, y, z = normal
        return cls(first, second, point, (x * force, y * force, z * force), normal)

    @property
    def swapped(self) -> Contact:
        """The same, as the other one feels it."""
        (fx, fy, fz), (nx, ny, nz) = self.force, self.normal
        return Contact(self.second, self.first, self.point, (-fx, -fy, -fz), (-nx, -ny, -nz))


class ContactSensor(Bumper):
    """A bumper that knows which things it was kept out of, by their place among the surroundings."""

    def __init__(self, surroundings: Clearance, start: Pose) -> None:
        super().__init__(surroundings, start)
        self.touching: set[int] = set()

    def move_to(self, surroundings: Clearance | None, start: Pose) -> None:
        """Begin anew, elsewhere or among other things."""
        super().__init__(surroundings or self._clearances, start)
        self.touching = set()

    def permits(self, here: Pose, there: Pose, distance: float, turn: float) -> bool:
        is_free = super().permits(here, there, distance, turn)
        if not is_free:
            self.touching.update(np.flatnonzero(self._clearances.gaps(there) < 0).tolist())
        return is_free


def nearest_points(body: Outline, other: Outline) -> tuple[Array, Array]:
    """Return the nearest points of two outlines that are apart: on the first, and on the second."""
    return min(_corner_to_side(body, other), _side_to_corner(body, other), key=lambda ends: _length(*ends))


def _corner_to_side(corners: Outline, sides: Outline) -> tuple[Array, Array]:
    points = np.array(corners)
    nearest = nearest_on(edges_of([sides]), points)
    corner, side = np.unravel_index(
        np.linalg.norm(nearest - points[:, None], axis=2).argmin(),
        nearest.shape[:2],
    )
    return points[corner], nearest[corner, side]


def _side_to_corner(sides: Outline, corners: Outline) -> tuple[Array, Array]:
    corner, point = _corner_to_side(corners, sides)
    return point, corner


def _length(a: Array, b: Array) -> float:
    return float(np.linalg.norm(a - b))
