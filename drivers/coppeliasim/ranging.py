"""The range sensor of a robot that was built: a fan of distances, by a vision sensor one pixel high."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drivers.coppeliasim.connection import Connection
from drivers.coppeliasim.eyes import Eye, add_eye
from drivers.coppeliasim.placing import Placement, mounted
from drivers.coppeliasim.probing import BOX_M, box_before
from drivers.coppeliasim.workshop import Workshop
from robotcore.description import RangeSensorDescription
from robotcore.errors import BackendError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Range, RangeSensor
from robotcore.raycast import FAN_RAYS, FAN_SETBACK_M, Fan
from robotcore.simulation.sampling import OnceAnInstant

_PROBED_M = 0.01

Array = NDArray[np.float64]

BEAM_RAD = 0.01
_JUST_UNDER = 1e-3
"""Where nothing is in view, depth reads a little less than the farthest."""


def add_fan(workshop: Workshop, told: RangeSensorDescription, body: int, frame: Placement, met: int) -> int:
    """Make the vision sensor of a fan; its outermost pixels look along the edges of the cone, at a collection."""
    cone = max(told.cone_rad, BEAM_RAD)
    fov = 2 * math.atan(math.tan(cone / 2) * FAN_RAYS / (FAN_RAYS - 1))
    eye = Eye((FAN_RAYS, 1), fov, far_m=reach(told), seen=met, ignored="rgb")
    return add_eye(workshop, eye, told.name, frame.at(mounted(told.mount, behind_m=FAN_SETBACK_M)), body)


def reach(told: RangeSensorDescription) -> float:
    """Return how far the fan looks, from where its rays begin, in metres."""
    return told.max_range_m + 2 * FAN_SETBACK_M


def require_depth(workshop: Workshop, connection: Connection) -> None:
    """Raise BackendError where a box right in front of a vision sensor is not seen.

    One that is not rendered, for want of graphics, tells the farthest depth: the way would seem free.
    """
    eye = Eye((FAN_RAYS, 1), BEAM_RAD, far_m=2 * BOX_M, ignored="rgb")
    with box_before(workshop, partial(add_eye, workshop, eye, "", Placement(0.0, 0.0, 0.0), -1)) as sensor:
        seen = _looked(connection, sensor).min()
    if abs(seen - BOX_M) > _PROBED_M:
        raise BackendError(
            f"coppeliasim: the CoppeliaSim at {connection.address} measures no distances: it does not detect a box in "
            f"front of a proximity sensor, and a vision sensor sees it {seen:.2f} m away, which is {BOX_M} m. Start it "
            "where it can draw (OpenGL), or take one with the plug-in for proximity sensors"
        )


class FanRangeSensor(RangeSensor):
    """Reads depth along the optical axis, and divides it by each ray's cosine."""

    def __init__(self, connection: Connection, told: RangeSensorDescription, sensor: int, clock: Clock) -> None:
        limits = {"min_range": told.min_range_m, "max_range": told.max_range_m}
        super().__init__(told.name, cone=told.cone_rad, **limits)
        self._connection, self._sensor = connection, sensor
        self._fan = Fan(cone=told.cone_rad, **limits)
        side = np.tan(max(told.cone_rad, BEAM_RAD) / 2)
        self._slopes = np.linspace(side, -side, FAN_RAYS)  # the first pixel is the leftmost
        self._stretch = np.hypot(1.0, self._slopes)
        self._far = reach(told) * (1 - _JUST_UNDER)
        self._newest_at = OnceAnInstant(clock, self._listen)

    def _newest(self) -> Range:
        return self._newest_at()

    def _listen(self, time: float, sequence: int) -> Range:
        depth = _looked(self._connection, self._sensor)
        lengths = np.where(depth < self._far, depth * self._stretch, math.inf)
        distance = self._fan.reading(lengths)
        return Range(distance, time, sequence, None if math.isinf(distance) else self._point(lengths))

    def _point(self, lengths: Array) -> tuple[float, float, float]:
        """Return the detected point in the sensor's frame."""
        ray = int(lengths.argmin())
        ahead = float(lengths[ray] / self._stretch[ray])
        return ahead - FAN_SETBACK_M, ahead * float(self._slopes[ray]), 0.0


def _looked(connection: Connection, sensor: int) -> Array:
    """Return how far a vision sensor sees now, in metres."""
    connection.sim("handleVisionSensor", sensor)  # unasked, it tells the depth of before
    return connection.told(_depths, "getVisionSensorDepth", sensor, 1)


def _depths(told: object) -> Array:
    """Return a row of depths in metres; raises ValueError where it is none."""
    if not (isinstance(told, tuple) and isinstance(told[0], bytes) and len(told[0]) == 4 * FAN_RAYS):
        raise ValueError("no row of depths")
    return np.frombuffer(told[0], dtype="<f4").astype(np.float64)
