"""Samples of a simulator: taken when they are read, and never twice at one instant."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic

from robotcore.hal.clock import Clock
from robotcore.hal.devices import SampleT


class SampleCache(Generic[SampleT]):
    """Calls ``take(time, sequence)`` at the first read of each instant; samples are numbered from 0."""

    def __init__(self, clock: Clock, take: Callable[[float, int], SampleT]) -> None:
        self._clock = clock
        self._take = take
        self._sample: SampleT | None = None

    def __call__(self) -> SampleT:
        now = self._clock.now()
        last = self._sample
        if last is None or last.time != now:
            self._sample = last = self._take(now, 0 if last is None else last.sequence + 1)
        return last
