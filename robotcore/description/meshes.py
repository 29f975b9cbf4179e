"""The meshes of a world's surfaces for simulators, and the mapping of textures to the surfaces."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotcore.description.texture import Texture
from robotcore.description.world import Cylinder, Floor, Prism

Array = NDArray[np.float64]


class Wrap(NamedTuple):
    """The mapping of a texture to a plane.

    The texture coordinates of a point p in metres are ``axes @ p + shift``. Their unit is the size of a tile.
    """

    texture: Texture
    axes: Array
    """The unit vectors along the texture's columns and rows, divided by the size of a tile in metres, shape (2, 3)."""
    shift: Array
    """The texture coordinates of the origin, shape (2,)."""

    @classmethod
    def from_middle(cls, texture: Texture, middle: ArrayLike, along: ArrayLike, up: ArrayLike) -> Wrap:
        """Return the mapping in which a point has the texture coordinates 0.

        texture: the texture.
        middle: the point, in metres, shape (3,).
        along: the unit vector along which the texture's column grows, shape (3,).
        up: the unit vector along which the texture's row grows, shape (3,).
        """
        axes = np.array((along, up), dtype=np.float64) / texture.scale_m
        return cls(texture, axes, -axes @ np.asarray(middle))

    def tiles(self, points: Array) -> Array:
        """Return the texture coordinates, shape (n, 2), of points of the plane in metres, shape (n, 3)."""
        return points @ self.axes.T + self.shift


def floor_wrap(floor: Floor) -> Wrap | None:
    """Return the texture mapping of the floor, or None for a floor without texture."""
    if floor.texture is None:
        return None
    return Wrap.from_middle(floor.texture, (0, 0, 0), (1, 0, 0), (0, 1, 0))


def face_wrap(prism: Prism, normal: Array) -> Wrap | None:
    """Return the texture mapping of a face of a prism, or None for a prism without texture.

    The texture of a side begins at the floor. On a box, it also begins in the middle of each side. On a cylinder, it
    continues from side to side. The texture of the top is parallel to the prism's own axes.

    prism: the prism.
    normal: the outward unit normal of the face, shape (3,).
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
"""The numbers of faces around a ball's mesh and from its top to its bottom.

Simulators draw balls as this mesh, because their own spheres can be coarser. The outline of PyBullet's own sphere has
an area that is 7.5 % too small.
"""


class Mesh(NamedTuple):
    """A surface as triangles, with normals and texture coordinates."""

    vertices: list[list[float]]
    """The positions of the vertices, in metres, n lists of three numbers."""
    normals: list[list[float]]
    """The unit normal at each vertex, n lists of three numbers."""
    indices: list[int]
    """Three indices of vertices for each triangle, counter-clockwise if seen from outside."""
    uvs: list[list[float]]
    """The texture coordinates of each vertex, n lists of two numbers; empty without a texture."""


def prism_mesh(prism: Prism) -> Mesh:
    """Return the mesh of a prism in the prism's own frame."""
    here = prism.model_copy(update={"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0})
    base = np.array([(x, y, 0.0) for x, y in here.outline])
    top = base + np.array((0.0, 0.0, prism.height_m))
    sides = [
        np.array((base[i], base[j], top[j], top[i]))
        for i, j in zip(range(len(base)), [*range(1, len(base)), 0], strict=True)
    ]
    return _make_mesh([top, base[::-1], *sides], partial(face_wrap, here))


Rectangle = tuple[float, float, float, float]
"""The least x, the least y, the greatest x and the greatest y of a rectangle on the floor, in metres."""


def ground_mesh(half: float, floor: Floor, hole: Rectangle | None = None) -> Mesh:
    """Return the mesh of the ground: a square around the origin with the floor's texture.

    half: half the length of the square's sides, in metres.
    hole: a rectangle within the square that is left out.
    """
    if hole is None:
        parts = [(-half, -half, half, half)]
    else:
        left, bottom, right, top = hole
        xs, ys = pairwise((-half, left, right, half)), [*pairwise((-half, bottom, top, half))]
        parts = [(x[0], y[0], x[1], y[1]) for x in xs for y in ys if (x[0], y[0]) != (left, bottom)]
    return _make_mesh([_list_corners(part) for part in parts], lambda _: floor_wrap(floor))


def sheet_mesh(rectangle: Rectangle) -> Mesh:
    """Return the mesh of a rectangle on the floor. Its texture coordinates are from 0 to 1 along x and y."""
    corners = _list_corners(rectangle)
    uvs = [[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]]
    return _make_mesh([corners], lambda _: None)._replace(uvs=uvs)


def _list_corners(rectangle: Rectangle) -> Array:
    left, bottom, right, top = rectangle
    return np.array(((right, top, 0.0), (left, top, 0.0), (left, bottom, 0.0), (right, bottom, 0.0)))


def ball_mesh(radius: float) -> Mesh:
    """Return the mesh of a ball around the origin with a radius in metres.

    The mesh is a little larger than the ball, so that its outline, a polygon, has the area of the circle. A regular
    polygon of n corners on a circle of radius r has the area n/2·sin(2π/n)·r², and the circle has π·r².
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


def _make_mesh(faces: list[Array], wrap_of: Callable[[Array], Wrap | None]) -> Mesh:
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
