"""A proximity sensor of a scene as a range sensor."""

from __future__ import annotations

import math

from robotcore.description import RangeSensorDescription
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Range, RangeSensor
from robotcore.simulation.remote_scene.port import Scene
from robotcore.simulation.sampling import OnceAnInstant


class SceneRangeSensor(RangeSensor):
    """The way to the point that a proximity sensor detects.

    The point itself is not told: how somebody's sensor is turned about its axis is not known.
    """

    def __init__(self, description: RangeSensorDescription, scene: Scene, sensor: int, clock: Clock) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._scene, self._sensor = scene, sensor
        self._newest_at = OnceAnInstant(clock, self._sense)

    def _newest(self) -> Range:
        return self._newest_at()

    def _sense(self, time: float, sequence: int) -> Range:
        point = self._scene.detected(self._sensor)
        distance = math.inf if point is None else math.hypot(*point)
        return Range(math.inf if distance > self.max_range else max(distance, self.min_range), time, sequence)
