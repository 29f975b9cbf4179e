"""The time of a recording."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Sequence

from robotcore.errors import RecordingEndedError
from robotcore.hal.clock import Callback, Clock

_SAME_S = 1e-9
"""What sums of periods make of one time."""


class ReplayClock(Clock):
    """Stands at one of the ``times`` of a recording's ticks, in seconds; a sleep takes it to the next.

    It goes on to where the deadline has come, so a loop at the recorded rate meets each tick. Past the last it raises
    RecordingEndedError.
    """

    def __init__(self, times: Sequence[float]) -> None:
        self._times = times
        self._now = times[0]
        self._calls: list[tuple[float, int, Callback]] = []
        self._order = itertools.count()
        self.tick = 0

    def now(self) -> float:
        return self._now

    def sleep_until(self, deadline: float) -> bool:
        is_ahead = deadline >= self._now
        self._go_on()
        while self.tick + 1 < len(self._times) and self._times[self.tick + 1] <= deadline + _SAME_S:
            self._go_on()
        return is_ahead

    def call_at(self, deadline: float, callback: Callback) -> None:
        heapq.heappush(self._calls, (deadline, next(self._order), callback))

    def close(self) -> None:
        self._calls.clear()

    def _go_on(self) -> None:
        """Go to the next tick, and make the calls that are due on the way."""
        if self.tick + 1 == len(self._times):
            raise RecordingEndedError(len(self._times), self._now)
        self.tick += 1
        while self._calls and self._calls[0][0] <= self._times[self.tick]:
            self._now, _, callback = heapq.heappop(self._calls)
            callback()
        self._now = self._times[self.tick]
