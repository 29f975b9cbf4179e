"""What a range sensor hears: the fan of rays in plan, at the sensor's height."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.description import RangeSensorDescription, WorldDescription
from robotcore.geometry import Pose
from robotcore.raycast import FAN_SETBACK_M, Fan, cast, edges_of

Array = NDArray[np.float64]
Point = tuple[float, float, float]


class Echo(NamedTuple):
    """A distance in metres, and in the sensor's frame the point that it comes from, if any."""

    distance: float
    point: Point | None


class Sonar:
    """Casts a sensor's fan at whatever of the world stands as high as the sensor."""

    def __init__(self, sensor: RangeSensorDescription, world: WorldDescription) -> None:
        mount = sensor.mount
        self._mount = Pose(mount.x_m, mount.y_m, mount.yaw_rad)
        self._fan = Fan(sensor.cone_rad, sensor.min_range_m, sensor.max_range_m)
        self._edges = edges_of(prism.outline for prism in world.prisms if prism.height_m > mount.z_m)
        self._circles = np.array(
            [(ball.x_m, ball.y_m, ball.radius_m**2 - (mount.z_m - ball.radius_m) ** 2) for ball in world.targets]
        ).reshape(-1, 3)

    def listen(self, robot: Pose) -> Echo:
        """Return what the sensor hears on a robot at ``robot``."""
        sensor = robot.moved(self._mount)
        x, y = sensor.to_world(-FAN_SETBACK_M, 0.0)
        dx, dy = self._fan.directions(sensor)
        lengths = np.minimum(cast(x, y, dx, dy, self._edges), cast_at_circles(x, y, dx, dy, self._circles))
        return Echo(self._fan.reading(lengths), self._fan.point(lengths))


def cast_at_circles(x: float, y: float, dx: Array, dy: Array, circles: Array) -> Array:
    """Return for each ray of unit direction, (n,), the distance to the first circle; ``inf`` if none.

    ``circles`` are (m, 3): centre, and radius squared; one below zero is never hit.
    """
    to_x, to_y = circles[:, 0] - x, circles[:, 1] - y
    along = np.outer(dx, to_x) + np.outer(dy, to_y)
    beside = np.outer(dx, to_y) - np.outer(dy, to_x)
    half_chord = np.sqrt(np.maximum(circles[:, 2] - beside**2, 0.0))
    hit = (beside**2 <= circles[:, 2]) & (along >= half_chord)
    nearest: Array = np.where(hit, along - half_chord, math.inf).min(axis=1, initial=math.inf)
    return nearest
