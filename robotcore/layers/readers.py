"""Layers over sensors, as functions on the way a sample takes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic

from robotcore.clock import TickClock
from robotcore.devices import SampleT
from robotcore.errors import StaleSampleError
from robotcore.safety import Latch

Reader = Callable[[], SampleT]


class OnceATick(Generic[SampleT]):
    """Within one tick, one sample, however often it is read; ``latest`` is the one read last."""

    def __init__(self, clock: TickClock, read: Reader[SampleT]) -> None:
        self._clock = clock
        self._read = read
        self._tick = -1
        self._sample: SampleT | None = None

    @property
    def latest(self) -> SampleT | None:
        return self._sample

    def __call__(self) -> SampleT:
        if self._sample is None or self._tick != self._clock.tick:
            self._sample = self._read()
            self._tick = self._clock.tick
        return self._sample


class Fresh(Generic[SampleT]):
    """No sample older than ``limit`` seconds: StaleSampleError instead, which ends the run."""

    def __init__(self, device: str, clock: TickClock, limit: float, latch: Latch, read: Reader[SampleT]) -> None:
        self._device, self._clock, self._limit, self._latch, self._read = device, clock, limit, latch, read

    def __call__(self) -> SampleT:
        sample = self._read()
        age = self._clock.now() - sample.time
        if age > self._limit:
            self._latch.trip(StaleSampleError(self._device, age, self._limit))
        return sample
