"""The motors and the range sensors of a simulated robot."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drivers.kinematic.motion import Wheel
from robotcore.description import Mount, WorldDescription
from robotcore.geometry import Pose
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.kinds.range_sensor import Echo, RangeSensorDescription
from robotcore.raycast import FAN_SETBACK_M, Fan, cast, edges_of


class KinematicMotor(Motor):
    """A simulated motor that sets the target velocity of its wheel."""

    def __init__(self, description: MotorDescription, wheel: Wheel) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._wheel, self._respond = wheel, description.respond

    def _apply(self, rad_s: float) -> None:
        self._wheel.target = self._respond(rad_s)


Array = NDArray[np.float64]


class WorldSlice:
    """The outlines of all bodies of a world at a height ``z_m`` in metres."""

    def __init__(self, world: WorldDescription, z_m: float) -> None:
        edges = edges_of(prism.outline for prism in world.prisms if prism.height_m > z_m)
        self._edges = np.asfortranarray(edges)  # `cast` computes with its columns
        self._circles = np.array(
            [(ball.x_m, ball.y_m, ball.radius_m**2 - (z_m - ball.radius_m) ** 2) for ball in world.targets]
        ).reshape(-1, 3)

    def cast(self, x: float, y: float, dx: Array, dy: Array) -> Array:
        """Return the length of each ray to its first hit, as (n,) in metres; ``inf`` without a hit.

        x, y: the common start of all rays, in metres.
        dx, dy: the unit vectors of the rays, each (n,).
        """
        return np.minimum(cast(x, y, dx, dy, self._edges), cast_at_circles(x, y, dx, dy, self._circles))


class Sonar:
    """Casts the fan of rays of a range sensor at all bodies at the height of the sensor."""

    def __init__(self, sensor: RangeSensorDescription, world: WorldDescription) -> None:
        self._mount = sensor.mount
        self._fan = Fan(sensor.cone_rad, sensor.min_range_m, sensor.max_range_m)
        self._slice = WorldSlice(world, sensor.mount.z_m)

    def measure(self, robot: Pose, mount: Mount | None = None) -> Echo:
        """Return the echo that the sensor receives if the robot has the pose ``robot``.

        mount: the present mount of a sensor on a servo.
        """
        sensor = robot.compose((mount or self._mount).pose)
        x, y = sensor.to_world(-FAN_SETBACK_M, 0.0)
        lengths = self._slice.cast(x, y, *self._fan.directions(sensor))
        return Echo(self._fan.reading(lengths), self._fan.point(lengths))


def cast_at_circles(x: float, y: float, dx: Array, dy: Array, circles: Array) -> Array:
    """Return the distance along each ray to the first circle, as (n,) in metres; ``inf`` without a hit.

    x, y: the common start of all rays, in metres.
    dx, dy: the unit vectors of the rays, each (n,).
    circles: x, y and the squared radius of each circle, (m, 3). A circle with a negative squared radius is never hit.
    """
    to_x, to_y = circles[:, 0] - x, circles[:, 1] - y
    dx, dy = dx[:, None], dy[:, None]
    squared_gap = (dx * to_y - dy * to_x) ** 2
    is_near = squared_gap <= circles[:, 2]
    if not np.count_nonzero(is_near):  # mostly, no circle lies in the direction of the rays
        return np.full(len(dx), math.inf)
    along = dx * to_x + dy * to_y
    half_chord = np.sqrt(np.maximum(circles[:, 2] - squared_gap, 0.0))
    hit = is_near & (along >= half_chord)
    nearest: Array = np.minimum.reduce(np.where(hit, along - half_chord, math.inf), axis=1)
    return nearest
