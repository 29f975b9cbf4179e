"""Ray casting against boxes, cylinders and spheroids."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.raycast import Fan
from tests.doubles.coppeliasim.scene.objects import Primitive, ProximitySensor, Shape
from tests.doubles.coppeliasim.scene.poses import Transform, Vector

Array = NDArray[np.float64]


class Hits(NamedTuple):
    """The first hit of each ray: its distance, its normal, and the index of the solid.

    The unit of a distance is the length of the ray's direction vector. Without a hit it is ``inf``.
    """

    lengths: Array
    normals: Array
    solids: NDArray[np.intp]


class Solids:
    """Placed shapes. A ray that begins inside a shape does not hit it, as with culled back faces."""

    def __init__(self, placed: Sequence[tuple[Shape, Transform]]) -> None:
        self.shapes = [shape for shape, _ in placed]
        self._centres = np.array([pose.position for _, pose in placed]).reshape(-1, 3)
        self._axes = np.array([pose.axes for _, pose in placed]).reshape(-1, 3, 3)
        self._halves = np.array([shape.size for shape in self.shapes]).reshape(-1, 3) / 2
        kinds = np.array([shape.primitive for shape in self.shapes], dtype=np.intp)
        self._by_kind = [(meet, np.flatnonzero(kinds == kind)) for kind, meet in _MEETINGS.items()]

    def cast(self, origin: Array, directions: Array) -> Array:
        """Return the distance of each ray to the first solid, (n,).

        All rays begin at ``origin``; the directions are (n, 3).
        """
        nearest: Array = self._lengths(origin, directions).min(axis=0, initial=np.inf)
        return nearest

    def hits(self, origin: Array, directions: Array) -> Hits:
        """Return the first hit of each ray. All rays begin at ``origin``; the directions are (n, 3)."""
        lengths = self._lengths(origin, directions)
        if not len(lengths):
            nothing = np.full(len(directions), np.inf)
            return Hits(nothing, np.zeros((len(directions), 3)), np.zeros(len(directions), np.intp))
        first = lengths.argmin(axis=0)
        nearest = lengths[first, np.arange(len(directions))]
        normals = np.zeros((len(directions), 3))
        for solid in np.unique(first[np.isfinite(nearest)]).tolist():
            rays = np.flatnonzero((first == solid) & np.isfinite(nearest))
            points = origin + directions[rays] * nearest[rays, None]
            normals[rays] = self._normals(solid, points)
        return Hits(nearest, normals, first)

    def _lengths(self, origin: Array, directions: Array) -> Array:
        starts = np.einsum("mij,mj->mi", self._axes, origin - self._centres) / self._halves
        ways = np.einsum("mij,nj->mni", self._axes, directions) / self._halves[:, None]
        lengths = np.full((len(starts), len(directions)), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            for meet, solids in self._by_kind:
                if len(solids):
                    lengths[solids] = meet(starts[solids, None], ways[solids])
        return lengths

    def _normals(self, solid: int, points: Array) -> Array:
        axes, halves = self._axes[solid], self._halves[solid]
        local = (points - self._centres[solid]) @ axes.T / halves
        kind = self.shapes[solid].primitive
        if kind is Primitive.CUBOID:
            out = np.eye(3)[np.abs(local).argmax(axis=1)] * np.sign(local)
        elif kind is Primitive.CYLINDER:
            on_cap = np.abs(local[:, 2]) > np.hypot(local[:, 0], local[:, 1])
            out = np.where(on_cap[:, None], np.sign(local) * (0, 0, 1), local * (1, 1, 0) / halves)
        else:
            out = local / halves
        turned = np.asarray(out @ axes)
        return np.asarray(turned / np.linalg.norm(turned, axis=1, keepdims=True))


def _compute_box_distances(starts: Array, ways: Array) -> Array:
    """Return the distances to cubes with edges of length 2. Source: the slab method of Kay and Kajiya."""
    one, other = (-1 - starts) / ways, (1 - starts) / ways
    enters = np.nan_to_num(np.minimum(one, other), nan=-np.inf, posinf=np.inf, neginf=-np.inf).max(axis=2)
    leaves = np.nan_to_num(np.maximum(one, other), nan=np.inf, posinf=np.inf, neginf=-np.inf).min(axis=2)
    return np.where((enters <= leaves) & (enters > 0), enters, np.inf)


def _compute_sphere_distances(starts: Array, ways: Array) -> Array:
    a, b = (ways * ways).sum(axis=2), (starts * ways).sum(axis=2)
    c = (starts * starts).sum(axis=2) - 1
    return _smaller_root(a, b, np.broadcast_to(c, a.shape))


def _compute_cylinder_distances(starts: Array, ways: Array) -> Array:
    flat, flat_ways = starts[..., :2], ways[..., :2]
    a, b = (flat_ways * flat_ways).sum(axis=2), (flat * flat_ways).sum(axis=2)
    c = np.broadcast_to((flat * flat).sum(axis=2) - 1, a.shape)
    side = _smaller_root(a, b, c)
    beyond = np.abs(starts[..., 2] + side * ways[..., 2]) > 1
    side = np.where(beyond | ~np.isfinite(side), np.inf, side)
    cap = (-np.sign(ways[..., 2]) - starts[..., 2]) / ways[..., 2]
    at_cap = flat + np.where(np.isfinite(cap), cap, 0.0)[..., None] * flat_ways
    cap = np.where((cap > 0) & np.isfinite(cap) & ((at_cap * at_cap).sum(axis=2) <= 1), cap, np.inf)
    return np.minimum(side, cap)


def _smaller_root(a: Array, b: Array, c: Array) -> Array:
    below = b * b - a * c
    root = (-b - np.sqrt(np.maximum(below, 0.0))) / a
    return np.where((below >= 0) & (root > 0) & (c > 0), root, np.inf)


_MEETINGS = {
    Primitive.CUBOID: _compute_box_distances,
    Primitive.SPHEROID: _compute_sphere_distances,
    Primitive.CYLINDER: _compute_cylinder_distances,
}


NEAREST_M = 0.001


class Detection(NamedTuple):
    """A detection of a proximity sensor: distance in metres, point and normal in the sensor's frame, and the object."""

    distance: float
    point: Vector
    handle: int
    normal: Vector


def detect(sensor: ProximitySensor, pose: Transform, solids: Solids) -> Detection | None:
    """Return the detection of a sensor along its z axis; None if it detects nothing.

    The point is on the shortest ray, at the returned distance. Clients of the legacy API compute the distance from the
    point.
    """
    farthest = sensor.offset + sensor.reach
    angles = Fan(sensor.cone, sensor.offset, farthest).angles
    sideways, _, ahead = (np.array(axis) for axis in pose.axes)
    directions = np.outer(np.sin(angles), sideways) + np.outer(np.cos(angles), ahead)
    hits = solids.hits(np.array(pose.position) - sensor.setback * ahead, directions)
    ray = int(hits.lengths.argmin())
    if (distance := float(hits.lengths[ray]) - sensor.setback) > farthest:
        return None
    distance, angle = max(distance, sensor.offset, NEAREST_M), float(angles[ray])
    point = (distance * math.sin(angle), 0.0, distance * math.cos(angle))
    across, up, along = np.array(pose.axes) @ hits.normals[ray]
    return Detection(distance, point, solids.shapes[hits.solids[ray]].handle, (float(across), float(up), float(along)))
