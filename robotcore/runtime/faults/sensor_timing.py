"""Faults in the timing of samples: lost, late or frozen samples."""

from __future__ import annotations

from collections import deque
from math import inf
from typing import Annotated

from pydantic import Field

from robotcore.hal.clock import Clock
from robotcore.hal.devices import SampleT, Sensor
from robotcore.runtime.faults.base import (
    ROUNDING_S,
    SENSORS,
    Fault,
    FaultContext,
    PollingLayer,
    Probability,
    TargetKind,
)
from robotcore.runtime.layers.base import Reader

Latency = Annotated[float, Field(gt=0, le=5, description="seconds")]


class Drop(Fault):
    """Samples are lost, each with the given probability. The sensor then returns its last sample again."""

    on = SENSORS
    example = "camera drop=0.2 after=5"

    value: Probability

    def layer(self, context: FaultContext) -> LostSamples:
        return LostSamples(self, context, self.value)


class NoEcho(Drop):
    """Echoes are lost, each with the given probability. The sensor then returns its last sample again, not ``inf``."""

    on = frozenset({TargetKind.RANGE})
    example = "range no_echo=0.5"


class Freeze(Fault):
    """All samples are lost. The sensor returns its last sample in each read."""

    on = SENSORS
    example = "camera freeze after=5 lasts=0.5"

    def layer(self, context: FaultContext) -> LostSamples:
        return LostSamples(self, context, 1.0)


class Delay(Fault):
    """Samples arrive late by the given time.

    The sensor returns its last sample until a newer one arrives. So the time of capture never decreases.
    """

    on = SENSORS
    example = "camera delay=0.2"

    value: Latency

    def layer(self, context: FaultContext) -> LateSamples:
        return LateSamples(self, context.clock)


class LostSamples(PollingLayer):
    """Drops the samples that are captured while ``fault`` is active, each with a probability.

    The first sample of a run is never dropped.
    """

    def __init__(self, fault: Fault, context: FaultContext, probability: float) -> None:
        super().__init__()
        self._fault, self._context, self._probability = fault, context, probability

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        last: SampleT | None = None

        def lossy() -> SampleT:
            nonlocal last
            newest = read()
            if last is None or not self._is_lost(sensor.name, newest.time):
                last = newest
            return last

        return self.poll(lossy)

    def _is_lost(self, device: str, time: float) -> bool:
        return self._fault.is_on(time) and self._context.random_at(device, time).random() < self._probability


class LateSamples(PollingLayer):
    """Delays the samples of sensors while ``fault`` is active. The first sample arrives without a delay."""

    def __init__(self, fault: Delay, clock: Clock) -> None:
        super().__init__()
        self._fault, self._clock = fault, clock

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        coming: deque[SampleT] = deque()

        def delayed() -> SampleT:
            coming.append(read())
            last_due = self._last_due()
            while len(coming) > 1 and coming[1].time <= last_due:
                coming.popleft()
            return coming[0]

        return self.poll(delayed)

    def _last_due(self) -> float:
        """Return the capture time, in seconds, of the newest sample that has arrived by now."""
        now = self._clock.now()
        return now - self._fault.value + ROUNDING_S if self._fault.is_on(now) else inf
