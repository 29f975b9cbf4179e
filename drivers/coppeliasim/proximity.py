"""Proximity sensors: whether a CoppeliaSim looks with them at all, and the range sensor that one makes."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from drivers.coppeliasim.placing import Placement, mounted
from drivers.coppeliasim.probing import box_before
from drivers.coppeliasim.scene import CoppeliaSimScene
from drivers.coppeliasim.workshop import Workshop
from robotcore.description import RangeSensorDescription
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Range, RangeSensor
from robotcore.raycast import FAN_SETBACK_M, Fan
from robotcore.simulation.sampling import OnceAnInstant

_PYRAMID, _EXPLICIT = 30, 1
_ULTRASONIC = 16
_THIN_M = 1e-3
"""How high the volume is that is looked into: it is a fan, and does not see the floor."""


def looks(workshop: Workshop, scene: CoppeliaSimScene) -> bool:
    """Return whether a box right in front of a proximity sensor is detected.

    Without its plug-in a CoppeliaSim answers "nothing", and the way would seem free.
    """
    with box_before(workshop, partial(_make, workshop, reach=1.0, cone=0.5)) as sensor:
        return scene.detected(sensor) is not None


def add_proximity_sensor(
    workshop: Workshop, told: RangeSensorDescription, body: int, frame: Placement, met: int
) -> int:
    """Make a flat fan that begins inside the body, and detects what is in a collection."""
    sensor = _make(workshop, told.max_range_m + FAN_SETBACK_M, told.cone_rad)
    workshop.set_int(sensor, "proxintparam_entity_to_detect", met)
    workshop.put(sensor, frame.at(mounted(told.mount, behind_m=FAN_SETBACK_M)), told.name, body)
    return sensor


class ProximityRangeSensor(RangeSensor):
    """The way to the nearest point that a proximity sensor detects."""

    def __init__(self, scene: CoppeliaSimScene, told: RangeSensorDescription, sensor: int, clock: Clock) -> None:
        limits = {"min_range": told.min_range_m, "max_range": told.max_range_m}
        super().__init__(told.name, cone=told.cone_rad, **limits)
        self._scene, self._sensor, self._fan = scene, sensor, Fan(cone=told.cone_rad, **limits)
        self._newest_at = OnceAnInstant(clock, self._listen)

    def _newest(self) -> Range:
        return self._newest_at()

    def _listen(self, time: float, sequence: int) -> Range:
        if (point := self._scene.detected(self._sensor)) is None:
            return Range(math.inf, time, sequence)
        left, up, ahead = point
        distance = self._fan.reading(np.array([math.hypot(*point)]))
        return Range(distance, time, sequence, None if math.isinf(distance) else (ahead - FAN_SETBACK_M, left, up))


def _make(workshop: Workshop, reach: float, cone: float) -> int:
    """Make a pyramid that opens sideways by ``cone``, and hardly upwards."""
    side = 2 * reach * math.tan(cone / 2)
    return workshop.make(
        "createProximitySensor",
        _PYRAMID,
        _ULTRASONIC,
        _EXPLICIT,
        [32, 0, 4, 1, 1, 1, 0, 0],
        [0.0, reach, _THIN_M, _THIN_M, side, _THIN_M, 0, 0, 0, 0, 0, 0, 0.01, 0, 0],
    )
