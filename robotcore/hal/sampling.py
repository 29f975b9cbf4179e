"""Takes samples of simulated sensors when the app reads them, at most one at each simulated time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic

from robotcore.hal.clock import Clock
from robotcore.hal.device import SampleT


class SampleCache(Generic[SampleT]):
    """Returns the sample of the present simulated time.

    The first call at a simulated time takes the sample. Further calls at this time return the same sample.

    clock: the simulated clock.
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
