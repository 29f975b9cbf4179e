"""Surfaces of a world as simulators draw them: meshes, and how a texture is laid on each face."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
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


BALL_SEGMENTS, BALL_RINGS = 32, 16
"""A simulator's own sphere may be drawn coarsely: Bullet's covers 7.5 % too little of a picture."""


class Mesh(NamedTuple):
    """Vertices and their normals, (n, 3), and three indices a triangle, counter-clockwise from outside.

    ``uvs``, (n, 2), are the vertices' places on a texture, in tiles; none where there is no texture.
    """

    vertices: list[list[float]]
    normals: list[list[float]]
    indices: list[int]
    uvs: list[list[float]]


def prism_mesh(prism: Prism) -> Mesh:
    """Return a prism around its own middle, not turned."""
    here = prism.model_copy(update={"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0})
    base = np.array([(x, y, 0.0) for x, y in here.outline])
    top = base + np.array((0.0, 0.0, prism.height_m))
    sides = [
        np.array((base[i], base[j], top[j], top[i]))
        for i, j in zip(range(len(base)), [*range(1, len(base)), 0], strict=True)
    ]
    return _faceted([top, base[::-1], *sides], partial(face_wrap, here))


def ground_mesh(half: float, floor: Floor) -> Mesh:
    """Return a square that looks up, and shows what a floor shows."""
    square = np.array(((half, half, 0.0), (-half, half, 0.0), (-half, -half, 0.0), (half, -half, 0.0)))
    return _faceted([square], lambda _: floor_wrap(floor))


def ball_mesh(radius: float) -> Mesh:
    """Return a ball around the origin, so much larger that its outline, a polygon, covers what the circle would.

    A regular polygon of n corners covers n/2·sin(2π/n) of its circle's radius squared, the circle π.
    """
    side = math.tau / BALL_SEGMENTS
    swollen = radius * math.sqrt(side / math.sin(side))
    polar = np.linspace(0, math.pi, BALL_RINGS + 1)[:, None]
    around = np.linspace(0, math.tau, BALL_SEGMENTS + 1)[None, :]
    z = np.broadcast_to(np.cos(polar), (BALL_RINGS + 1, BALL_SEGMENTS + 1))
    normals = np.stack((np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), z), axis=-1).reshape(-1, 3)
    row = BALL_SEGMENTS + 1
    corners = [ring * row + segment for ring in range(BALL_RINGS) for segment in range(BALL_SEGMENTS)]
    indices = [i for c in corners for i in (c, c + row, c + row + 1, c, c + row + 1, c + 1)]
    return Mesh((normals * swollen).tolist(), normals.tolist(), indices, [])


def _faceted(faces: list[Array], wrap_of: Callable[[Array], Wrap | None]) -> Mesh:
    """Return the mesh of convex faces, each given by its corners, (n, 3), and textured as its normal says."""
    normals: list[list[float]] = []
    indices: list[int] = []
    uvs: list[list[float]] = []
    for face in faces:
        start, across = len(normals), np.cross(face[1] - face[0], face[2] - face[1])
        normal = across / np.linalg.norm(across)
        normals += [normal.tolist()] * len(face)
        indices += [i for k in range(start + 1, start + len(face) - 1) for i in (start, k, k + 1)]
        uvs += wrap.tiles(face).tolist() if (wrap := wrap_of(normal)) else []
    return Mesh(np.concatenate(faces).tolist(), normals, indices, uvs)
