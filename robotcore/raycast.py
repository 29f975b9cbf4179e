"""Casts rays against polygons in the plane, and models a range sensor by a fan of rays."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robotcore.geometry import Pose
from robotcore.optics import Mounted

Array = NDArray[np.float64]
Outline = Sequence[tuple[float, float]]

FAN_RAYS = 15
"""The number of rays by which a simulator models a range sensor."""

FAN_SETBACK_M = 0.05
"""The distance in metres by which the rays begin behind the sensor.

So they also hit a body that touches the sensor.
"""


def edges_of(outlines: Iterable[Outline]) -> Array:
    """Return the edges of polygons, shape (n, 4).

    A row has the x and y of the edge's start, and the x and y of the vector from its start to its end.

    >>> edges_of([[(1.0, 0.0), (1.0, 2.0)]]).tolist()
    [[1.0, 0.0, 0.0, 2.0], [1.0, 2.0, 0.0, -2.0]]
    """
    edges = [
        (ax, ay, bx - ax, by - ay)
        for outline in outlines
        for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True)
    ]
    return np.array(edges, dtype=np.float64).reshape(-1, 4)


def cast(x: Array | float, y: Array | float, dx: Array, dy: Array, edges: Array) -> Array:
    """Return for each ray the distance to the first edge that it hits, shape (n,).

    The distance is a multiple of the length of the ray's direction vector. Without a hit, it is ``inf``.

    x, y: the common start of all rays, or the start of each ray, shape (n,).
    dx, dy: the direction vector of each ray, shape (n,).
    edges: the edges that `edges_of` returns.

    >>> wall = edges_of([[(2.0, -1.0), (2.0, 1.0)]])
    >>> cast(0.0, 0.0, np.array([1.0, -1.0]), np.array([0.0, 0.0]), wall).tolist()
    [2.0, inf]
    """
    if not len(edges):
        return np.full(dx.shape, math.inf)
    ex, ey = edges[:, 2], edges[:, 3]
    to_x = edges[:, 0] - np.asarray(x).reshape(-1, 1)
    to_y = edges[:, 1] - np.asarray(y).reshape(-1, 1)
    dx, dy = dx.reshape(-1, 1), dy.reshape(-1, 1)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        scale = 1.0 / (dx * ey - dy * ex)
        along_ray = (to_x * ey - to_y * ex) * scale
        along_edge = (to_x * dy - to_y * dx) * scale
        hit = (along_ray >= 0) & (along_edge >= 0) & (along_edge <= 1)
    nearest: Array = np.minimum.reduce(np.where(hit, along_ray, math.inf), axis=1)
    return nearest


@dataclass(frozen=True)
class Fan:
    """The horizontal fan of `FAN_RAYS` rays by which every simulator models a range sensor.

    >>> fan = Fan(cone=0.5, min_range=0.02, max_range=2.0)
    >>> lengths = np.full(FAN_RAYS, 1.05)  # the rays begin 0.05 m behind the sensor
    >>> fan.reading(lengths), fan.reading(lengths * 2)
    (1.0, inf)
    """

    cone: float
    """The full opening angle of the fan, in radians."""
    min_range: float
    """The shortest distance that the sensor measures, in metres."""
    max_range: float
    """The longest distance that the sensor measures, in metres."""

    @cached_property
    def angles(self) -> Array:
        """The angles from the sensor's axis to the rays, in radians, from right to left, shape (15,). Read-only."""
        angles = np.linspace(-self.cone / 2, self.cone / 2, FAN_RAYS)
        angles.flags.writeable = False
        return angles

    def rays(self, mount: Mounted) -> tuple[Array, Array]:
        """Return the start of all rays, shape (3,), and their unit vectors, shape (15, 3), in the robot's frame.

        mount: the pose of the sensor on the robot.
        """
        sensor = Pose(mount.x_m, mount.y_m, mount.yaw_rad)
        directions = self.directions(sensor)
        origin = np.array((*sensor.to_world(-FAN_SETBACK_M, 0.0), mount.z_m))
        return origin, np.stack((*directions, np.zeros_like(self.angles)), axis=1)

    def directions(self, sensor: Pose) -> tuple[Array, Array]:
        """Return the x and the y components of the rays' unit vectors, both of shape (15,).

        sensor: the pose of the sensor in the frame of the result.
        """
        angles = sensor.heading + self.angles
        return np.cos(angles), np.sin(angles)

    def reading(self, lengths: Array) -> float:
        """Return the distance that the sensor measures, in metres; ``inf`` if all hits are beyond its range.

        lengths: the length of each ray from its start to its hit, in metres, shape (15,).
        """
        nearest = lengths.item(lengths.argmin()) - FAN_SETBACK_M
        return math.inf if nearest > self.max_range else max(nearest, self.min_range)

    def point(self, lengths: Array) -> tuple[float, float, float] | None:
        """Return the nearest hit as x, y, z in the sensor's frame, in metres; None if it is beyond the sensor's range.

        lengths: the length of each ray from its start to its hit, in metres, shape (15,).
        """
        if math.isinf(self.reading(lengths)):
            return None
        ray = int(lengths.argmin())
        angle, length = self.angles.item(ray), lengths.item(ray)
        return length * math.cos(angle) - FAN_SETBACK_M, length * math.sin(angle), 0.0
