"""How a sensor is read: functions on the way that a sample takes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic

from robotcore.hal.clock import TickClock
from robotcore.hal.devices import SampleT

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
