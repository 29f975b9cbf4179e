"""How textures lie on the floor, on walls and on obstacles, the same in every renderer."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotcore.description.texture import Texture
from robotcore.description.world import Cylinder, Floor, Prism

Array = NDArray[np.float64]


class Wrap(NamedTuple):
    """A texture on a plane: a point p is ``axes @ p + shift``, (2,), counted in tiles along it and up it."""

    texture: Texture
    axes: Array
    shift: Array

    @classmethod
    def from_middle(cls, texture: Texture, middle: ArrayLike, along: ArrayLike, up: ArrayLike) -> Wrap:
        """Return the wrap that begins at ``middle``; ``along`` and ``up`` are unit vectors, (3,)."""
        axes = np.array((along, up), dtype=np.float64) / texture.scale_m
        return cls(texture, axes, -axes @ np.asarray(middle))

    def tiles(self, points: Array) -> Array:
        """Return where points of the plane, (n, 3), lie, (n, 2)."""
        return points @ self.axes.T + self.shift


def floor_wrap(floor: Floor) -> Wrap | None:
    """Return how the floor is textured: along x and y of the world; None where it is of one colour."""
    if floor.texture is None:
        return None
    return Wrap.from_middle(floor.texture, (0, 0, 0), (1, 0, 0), (0, 1, 0))


def face_wrap(prism: Prism, normal: Array) -> Wrap | None:
    """Return how the face of a prism with this outward unit normal, (3,), is textured; None where it is not.

    On a side, up from the floor: from a box's middle on every side, round a cylinder without end. On the top,
    along the prism's own axes.
    """
    if (texture := prism.texture) is None:
        return None
    middle = (prism.x_m, prism.y_m, 0.0)
    x, y, z = normal.tolist()
    if abs(z) > 0.5:
        cos, sin = math.cos(prism.yaw_rad), math.sin(prism.yaw_rad)
        return Wrap.from_middle(texture, middle, (cos, sin, 0), (-sin, cos, 0))
    wrap = Wrap.from_middle(texture, middle, (-y, x, 0), (0, 0, 1))
    if not isinstance(prism, Cylinder):
        return wrap
    turned = math.remainder(math.atan2(y, x) - prism.yaw_rad, math.tau)
    shift = np.array((prism.radius_m * turned / texture.scale_m, 0.0))
    return wrap._replace(shift=wrap.shift + shift)
