"""Rays in the plane against outlines, and the fan of rays that stands for an ultrasonic cone."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotcore.geometry import Pose
from robotcore.optics import Mounted

Array = NDArray[np.float64]
Outline = Sequence[tuple[float, float]]

FAN_RAYS = 15
FAN_SETBACK_M = 0.05
"""Rays begin this far behind the sensor, inside the body, so that what touches it is still hit."""


def edges_of(outlines: Iterable[Outline]) -> Array:
    """Return the edges of polygons as (n, 4): x and y of the start, x and y of the way to the end."""
    edges = [
        (ax, ay, bx - ax, by - ay)
        for outline in outlines
        for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True)
    ]
    return np.array(edges, dtype=np.float64).reshape(-1, 4)


def cast(x: Array | float, y: Array | float, dx: Array, dy: Array, edges: Array) -> Array:
    """Return for each ray, (n,), the distance to the first edge in units of its direction; ``inf`` if none."""
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
    nearest: Array = np.where(hit, along_ray, math.inf).min(axis=1)
    return nearest


@dataclass(frozen=True)
class Fan:
    """The horizontal fan of rays that every simulator casts for a range sensor."""

    cone: float
    min_range: float
    max_range: float

    @property
    def angles(self) -> Array:
        """The directions of the rays from the sensor's axis, (15,), right to left."""
        return np.linspace(-self.cone / 2, self.cone / 2, FAN_RAYS)

    def rays(self, mount: Mounted) -> tuple[Array, Array]:
        """Return in the robot's frame where the rays begin, (3,), and their unit vectors, (15, 3)."""
        sensor = Pose(mount.x_m, mount.y_m, mount.yaw_rad)
        directions = self.directions(sensor)
        origin = np.array((*sensor.to_world(-FAN_SETBACK_M, 0.0), mount.z_m))
        return origin, np.stack((*directions, np.zeros_like(self.angles)), axis=1)

    def directions(self, sensor: Pose) -> tuple[Array, Array]:
        """Return the unit vectors of the rays, x and y, (15,) each."""
        angles = sensor.heading + self.angles
        return np.cos(angles), np.sin(angles)

    def reading(self, lengths: Array) -> float:
        """Return the distance that rays of these lengths, begun FAN_SETBACK_M behind, amount to, in metres."""
        nearest = float(lengths.min()) - FAN_SETBACK_M
        return math.inf if nearest > self.max_range else max(nearest, self.min_range)

    def point(self, lengths: Array) -> tuple[float, float, float] | None:
        """Return what rays of these lengths hit first, in the sensor's frame, in metres; None out of range."""
        if math.isinf(self.reading(lengths)):
            return None
        ray = int(lengths.argmin())
        angle, length = float(self.angles[ray]), float(lengths[ray])
        return length * math.cos(angle) - FAN_SETBACK_M, length * math.sin(angle), 0.0
