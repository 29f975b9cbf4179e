"""The encoder and the range sensor: nothing is measured unless it is read."""

from __future__ import annotations

import math

import numpy as np

from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from robotcore.description import EncoderDescription, RangeSensorDescription
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Encoder, Range, RangeSensor
from robotcore.raycast import FAN_SETBACK_M, Fan
from robotcore.simulation.sampling import OnceAnInstant


class BulletEncoder(Encoder):
    """Whole counts of a wheel's joint."""

    def __init__(self, bullet: Bullet, description: EncoderDescription, clock: Clock, body: Body) -> None:
        super().__init__(description.name)
        self._description = description
        self._joint_state = bullet.getJointState
        self._body, self._joint = body.number, body.joint_of(self.name)
        self._newest_at = OnceAnInstant(clock, self._count)

    def _newest(self) -> Angle:
        return self._newest_at()

    def _count(self, time: float, sequence: int) -> Angle:
        angle = self._joint_state(self._body, self._joint)[0]
        return Angle(self._description.quantised(angle), time, sequence)


class BulletRangeSensor(RangeSensor):
    """The fan of rays. It meets things only: robot and floor are in no group that rays collide with."""

    def __init__(self, bullet: Bullet, description: RangeSensorDescription, clock: Clock, body: Body) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._fan = Fan(cone=description.cone_rad, **limits)
        self._length = self.max_range + 2 * FAN_SETBACK_M
        self._origin, directions = self._fan.rays(description.mount)
        self._rays = directions * self._length
        self._cast = bullet.rayTestBatch
        self._body = body
        self._newest_at = OnceAnInstant(clock, self._listen)

    def _newest(self) -> Range:
        return self._newest_at()

    def _listen(self, time: float, sequence: int) -> Range:
        rotation, origin = self._body.transform()
        start = origin + rotation @ self._origin
        ends = start + self._rays @ rotation.T
        hits = self._cast([start] * len(ends), ends)
        lengths = np.array([hit[2] * self._length if hit[0] >= 0 else math.inf for hit in hits])
        return Range(self._fan.reading(lengths), time, sequence, self._fan.point(lengths))
