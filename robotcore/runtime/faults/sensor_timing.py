"""Faults in the timing of samples: lost, late or frozen samples. The first sample of a run is never lost or late."""

from __future__ import annotations

from collections import deque
from math import inf
from typing import Annotated, Any, ClassVar

from pydantic import Field

from robotcore.hal.device import Sensor
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.runtime.faults.base import ROUNDING_S, FaultContext, Probability, SensorFault
from robotcore.runtime.layers.base import Reader

Latency = Annotated[float, Field(gt=0, le=5, description="seconds")]


class SampleLoss(SensorFault):
    """The base class of faults that lose samples. The sensor then returns its last sample again."""

    target_classes: ClassVar[tuple[type, ...]] = (Sensor,)
    is_polling = True

    def is_lost(self, context: FaultContext, device: str, time: float) -> bool:
        """Return whether the sample that a device captured at ``time``, in seconds, is lost during the fault."""
        return True

    def change(self, context: FaultContext, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        last: Any = None

        def read_lossy() -> Any:
            nonlocal last
            newest = read()
            if last is None or not (self.is_active(newest.time) and self.is_lost(context, sensor.name, newest.time)):
                last = newest
            return last

        return read_lossy


class Freeze(SampleLoss):
    """All samples are lost. The sensor returns its last sample in each read."""

    example = "camera freeze after=5 lasts=0.5"


class Drop(SampleLoss):
    """Samples are lost, each with the given probability. The sensor then returns its last sample again."""

    example = "camera drop=0.2 after=5"

    value: Probability

    def is_lost(self, context: FaultContext, device: str, time: float) -> bool:
        return context.random_at(device, time).random() < self.value


class NoEcho(Drop):
    """Echoes are lost, each with the given probability. The sensor then returns its last sample again, not infinity."""

    target_classes = (RangeSensor,)
    example = "range no_echo=0.5"


class Delay(SensorFault):
    """Samples arrive late by the given time.

    The sensor returns its last sample until a newer one arrives. So the time of capture never decreases.
    """

    target_classes = (Sensor,)
    example = "camera delay=0.2"
    is_polling = True

    value: Latency

    def change(self, context: FaultContext, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        coming: deque[Any] = deque()

        def read_late() -> Any:
            coming.append(read())
            now = context.clock.now()
            last_due = now - self.value + ROUNDING_S if self.is_active(now) else inf
            while len(coming) > 1 and coming[1].time <= last_due:
                coming.popleft()
            return coming[0]

        return read_late
