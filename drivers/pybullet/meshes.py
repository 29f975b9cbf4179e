"""Triangle meshes for Bullet, each face with vertices and a normal of its own so that its edges stay sharp."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.raycast import Outline

Array = NDArray[np.float64]

BALL_SEGMENTS, BALL_RINGS = 32, 16
"""Bullet's own sphere is drawn so coarsely that it covers 7.5 % too little of a picture."""


class Mesh(NamedTuple):
    """Vertices and their normals, (n, 3), and three indices a triangle, counter-clockwise from outside."""

    vertices: list[list[float]]
    normals: list[list[float]]
    indices: list[int]


def prism_mesh(outline: Outline, height: float) -> Mesh:
    """Return a prism that stands on a convex outline."""
    base = np.array([(x, y, 0.0) for x, y in outline])
    top = base + np.array((0.0, 0.0, height))
    sides = [
        np.array((base[i], base[j], top[j], top[i]))
        for i, j in zip(range(len(base)), [*range(1, len(base)), 0], strict=True)
    ]
    return _faceted([top, base[::-1], *sides])


def ground_mesh(half: float) -> Mesh:
    """Return a square that looks up."""
    return _faceted([np.array(((half, half, 0.0), (-half, half, 0.0), (-half, -half, 0.0), (half, -half, 0.0)))])


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
    return Mesh((normals * swollen).tolist(), normals.tolist(), indices)


def _faceted(faces: list[Array]) -> Mesh:
    """Return the mesh of convex faces, each given by its corners, (n, 3)."""
    normals, indices, start = [], [], 0
    for face in faces:
        normal = np.cross(face[1] - face[0], face[2] - face[1])
        normals += [(normal / np.linalg.norm(normal)).tolist()] * len(face)
        indices += [i for k in range(start + 1, start + len(face) - 1) for i in (start, k, k + 1)]
        start += len(face)
    return Mesh(np.concatenate(faces).tolist(), normals, indices)
