"""The range sensor: rays are cast when it is read, and only then."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from drivers.mujoco.body import Array, Body
from drivers.mujoco.model.groups import HEARD, flags
from robotcore.description import RangeSensorDescription
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Range, RangeSensor
from robotcore.raycast import FAN_RAYS, FAN_SETBACK_M, Fan
from robotcore.simulation.sampling import OnceAnInstant

if TYPE_CHECKING:
    from mujoco import MjData, MjModel


class MujocoRangeSensor(RangeSensor):
    """The fan of rays. It meets what stands in the world: robot and floor are in groups that it does not hear."""

    def __init__(
        self, model: MjModel, data: MjData, description: RangeSensorDescription, clock: Clock, body: Body
    ) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._model, self._data, self._body = model, data, body
        self._fan = Fan(cone=description.cone_rad, **limits)
        self._origin, self._rays = self._fan.rays(description.mount)
        self._groups = np.array(flags(HEARD), dtype=np.uint8)
        self._hit, self._lengths = np.zeros(FAN_RAYS, dtype=np.int32), np.zeros(FAN_RAYS)
        self._newest_at = OnceAnInstant(clock, self._listen)

    def _newest(self) -> Range:
        return self._newest_at()

    def _listen(self, time: float, sequence: int) -> Range:
        lengths = self._cast()
        return Range(self._fan.reading(lengths), time, sequence, self._fan.point(lengths))

    def _cast(self) -> Array:
        """Return how far each ray goes, (15,), in metres; ``inf`` where it meets nothing."""
        from mujoco import mj_multiRay

        rotation, origin = self._body.transform()
        start, rays = origin + rotation @ self._origin, (self._rays @ rotation.T).ravel()
        reach = self.max_range + 2 * FAN_SETBACK_M
        into = (self._hit, self._lengths, None)
        mj_multiRay(self._model, self._data, start, rays, self._groups, True, -1, *into, FAN_RAYS, reach)
        return np.where(self._hit >= 0, self._lengths, math.inf)
