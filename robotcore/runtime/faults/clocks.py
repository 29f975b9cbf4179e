"""Clocks that do something of their own before, or instead of, letting time pass."""

from __future__ import annotations

from collections.abc import Callable

from robotcore.hal.clock import Clock, ClockOver
from robotcore.runtime.faults.fault import ROUNDING_S


class EndingTicks(ClockOver):
    """Calls ``end_tick`` at the end of each tick, just before time passes."""

    def __init__(self, source: Clock, end_tick: Callable[[], None]) -> None:
        super().__init__(source)
        self._end_tick = end_tick

    def sleep_until(self, deadline: float) -> bool:
        self._end_tick()
        return super().sleep_until(deadline)


class Stalling(ClockOver):
    """Comes back ``stall`` seconds later from the first tick at ``first`` or after; then again ``every`` seconds.

    No stall begins at ``end`` or later. Time, and all that others have asked for, goes on meanwhile.
    """

    def __init__(self, source: Clock, stall: float, first: float, every: float, end: float) -> None:
        super().__init__(source)
        self._stall, self._due, self._every, self._end = stall, first, every, end

    def sleep_until(self, deadline: float) -> bool:
        now = self.now() + ROUNDING_S
        if not self._due <= now < self._end:
            return super().sleep_until(deadline)
        while self._due <= now:
            self._due += self._every
        awake = now - ROUNDING_S + self._stall
        return super().sleep_until(max(deadline, awake)) and awake <= deadline
