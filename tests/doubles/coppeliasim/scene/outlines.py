"""Shapes that stand upright: their outlines in plan and their heights, and contacts between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from drivers.kinematic.clearance import Bumper, Clearance
from robotcore.description import Ball, Box, Cylinder
from robotcore.description.world import Outline
from robotcore.geometry import Pose
from robotcore.raycast import edges_of
from robotcore.simulation.painter.planes import Array, find_nearest_points
from tests.doubles.coppeliasim.scene.objects import Primitive, Shape
from tests.doubles.coppeliasim.scene.poses import Transform, Vector

UPRIGHT = 0.9999
"""An axis whose z component exceeds this value counts as vertical."""


class UprightShape(NamedTuple):
    """An upright shape: its description in a world, and the heights of its lower and upper end."""

    shape: Shape
    description: Box | Cylinder | Ball
    low: float
    high: float

    @property
    def outline(self) -> Outline:
        return self.description.outline


def find_upright_shape(shape: Shape, pose: Transform) -> UprightShape | None:
    """Return the upright shape at ``pose``; None if it is tilted or of another primitive."""
    if shape.primitive is Primitive.CUBOID:
        return _box(shape, pose)
    if shape.primitive is Primitive.CYLINDER:
        return _cylinder(shape, pose)
    return _ball(shape, pose)


def find_lowest_z(shape: Shape, pose: Transform) -> float:
    """Return the height of a shape's lowest point, in metres."""
    x, y, z = (axis[2] * size / 2 for axis, size in zip(pose.axes, shape.size, strict=True))
    if shape.primitive is Primitive.CUBOID:
        reach = abs(x) + abs(y) + abs(z)
    elif shape.primitive is Primitive.CYLINDER:
        reach = math.hypot(x, y) + abs(z)
    else:
        reach = math.sqrt(x * x + y * y + z * z)
    return pose.position[2] - reach


def _box(shape: Shape, pose: Transform) -> UprightShape | None:
    up = next((i for i, axis in enumerate(pose.axes) if abs(axis[2]) > UPRIGHT), None)
    if up is None:
        return None
    along, across = (i for i in range(3) if i != up)
    ahead = pose.axes[along]
    box = Box.model_construct(
        shape="box",
        yaw_rad=math.atan2(ahead[1], ahead[0]),
        length_m=shape.size[along],
        width_m=shape.size[across],
        **_common(shape, pose, shape.size[up] / 2),
    )
    return _spanning(shape, box, pose, shape.size[up] / 2)


def _cylinder(shape: Shape, pose: Transform) -> UprightShape | None:
    if abs(pose.axes[2][2]) <= UPRIGHT or shape.size[0] != shape.size[1]:
        return None
    half = shape.size[2] / 2
    cylinder = Cylinder.model_construct(
        shape="cylinder", yaw_rad=pose.yaw, radius_m=shape.size[0] / 2, **_common(shape, pose, half)
    )
    return _spanning(shape, cylinder, pose, half)


def _ball(shape: Shape, pose: Transform) -> UprightShape | None:
    if len(set(shape.size)) > 1:
        return None
    radius = shape.size[0] / 2
    common = _common(shape, pose, radius)
    del common["height_m"], common["texture"]
    return _spanning(shape, Ball.model_construct(radius_m=radius, **common), pose, radius)


def _spanning(shape: Shape, description: Box | Cylinder | Ball, pose: Transform, half: float) -> UprightShape:
    return UprightShape(shape, description, pose.position[2] - half, pose.position[2] + half)


def _common(shape: Shape, pose: Transform, half: float) -> dict[str, Any]:
    x, y, z = pose.position
    colour = tuple(round(255 * min(max(part, 0.0), 1.0)) for part in shape.colour)
    return {"name": shape.alias, "x_m": x, "y_m": y, "height_m": z + half, "colour": colour, "texture": None}


Polygon = Sequence[tuple[float, float]]

GRAVITY_M_S2 = 9.81


class Contact(NamedTuple):
    """A contact of two shapes: their handles, the point in m, and the force in N and the normal towards ``first``."""

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
    def swap(self) -> Contact:
        """Return the same contact with both shapes exchanged."""
        (fx, fy, fz), (nx, ny, nz) = self.force, self.normal
        return Contact(self.second, self.first, self.point, (-fx, -fy, -fz), (-nx, -ny, -nz))


class ContactSensor(Bumper):
    """A bumper that records the index of each touched shape in the surroundings."""

    def __init__(self, surroundings: Clearance, start: Pose) -> None:
        super().__init__(surroundings, start)
        self.touching: set[int] = set()

    def move_to(self, surroundings: Clearance | None, start: Pose) -> None:
        """Set the pose of the body, and optionally the surroundings."""
        super().__init__(surroundings or self._clearances, start)
        self.touching = set()

    def try_move(self, here: Pose, there: Pose, distance: float, turn: float) -> bool:
        is_free = super().try_move(here, there, distance, turn)
        if not is_free:
            self.touching.update(np.flatnonzero(self._clearances.measure_gaps(there) < 0).tolist())
        return is_free


def nearest_points(body: Polygon, other: Polygon) -> tuple[Array, Array]:
    """Return the point of each of two separate outlines that is nearest to the other outline."""
    return min(_corner_to_side(body, other), _side_to_corner(body, other), key=lambda ends: _length(*ends))


def _corner_to_side(corners: Polygon, sides: Polygon) -> tuple[Array, Array]:
    points = np.array(corners)
    nearest = find_nearest_points(edges_of([sides]), points)
    corner, side = np.unravel_index(
        np.linalg.norm(nearest - points[:, None], axis=2).argmin(),
        nearest.shape[:2],
    )
    return points[corner], nearest[corner, side]


def _side_to_corner(sides: Polygon, corners: Polygon) -> tuple[Array, Array]:
    corner, point = _corner_to_side(corners, sides)
    return point, corner


def _length(a: Array, b: Array) -> float:
    return float(np.linalg.norm(a - b))
