"""A cache that takes a sensor's sample when the app reads it, at most one at each time of the clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic

from robotcore.hal.clock import Clock
from robotcore.hal.device import SampleT


class SampleCache(Generic[SampleT]):
    """Returns the sample of the clock's present time.

    The first call at a time of the clock takes the sample. Further calls at this time return the same sample.

    clock: the robot's clock.
    take: takes a sample. Its arguments are the time in seconds and the sequence number, which begins at 0.

    >>> from robotcore.hal.clock import SteppedClock
    >>> from robotcore.kinds.encoder import Angle
    >>> clock = SteppedClock(20, lambda steps: None)
    >>> read = SampleCache(clock, lambda time, sequence: Angle(0.5, time, sequence))
    >>> read() is read(), clock.sleep_until(0.1), read().sequence
    (True, True, 1)
    """

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
