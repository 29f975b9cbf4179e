"""Faults in the timing of samples: lost, late or frozen samples."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from math import inf
from typing import Annotated, Generic

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
        return LateSamples(self, self.value, context.clock)


class LostSamples(PollingLayer):
    """Drops the samples that are captured while ``fault`` is active, each with a probability.

    The first sample of a run is never dropped.
    """

    def __init__(self, fault: Fault, context: FaultContext, probability: float) -> None:
        super().__init__()
        self._fault, self._context, self._probability = fault, context, probability

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return self.poll(_LossyReader(read, lambda time: self._is_lost(sensor.name, time)))

    def _is_lost(self, device: str, time: float) -> bool:
        return self._fault.is_on(time) and self._context.random_at(device, time).random() < self._probability


class _LossyReader(Generic[SampleT]):
    def __init__(self, read: Reader[SampleT], is_lost: Callable[[float], bool]) -> None:
        self._read, self._is_lost = read, is_lost
        self._last: SampleT | None = None

    def __call__(self) -> SampleT:
        newest = self._read()
        if self._last is None or not self._is_lost(newest.time):
            self._last = newest
        return self._last


class LateSamples(PollingLayer):
    """Delays the samples of sensors by ``latency`` seconds while ``fault`` is active."""

    def __init__(self, fault: Fault, latency: float, clock: Clock) -> None:
        super().__init__()
        self._fault, self._latency, self._clock = fault, latency, clock

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return self.poll(_DelayedReader(read, self._last_due))

    def _last_due(self) -> float:
        """Return the capture time, in seconds, of the newest sample that has arrived by now."""
        now = self._clock.now()
        return now - self._latency + ROUNDING_S if self._fault.is_on(now) else inf


class _DelayedReader(Generic[SampleT]):
    """Returns the newest sample that has arrived. The first sample of a sensor arrives without a delay."""

    def __init__(self, read: Reader[SampleT], last_due: Callable[[], float]) -> None:
        self._read, self._last_due = read, last_due
        self._coming: deque[SampleT] = deque()

    def __call__(self) -> SampleT:
        coming = self._coming
        coming.append(self._read())
        last_due = self._last_due()
        while len(coming) > 1 and coming[1].time <= last_due:
            coming.popleft()
        return coming[0]
