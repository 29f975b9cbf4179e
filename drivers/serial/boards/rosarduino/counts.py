"""Counts that can be: a lost digit makes another number, and nothing on the line tells."""

from __future__ import annotations

import math

from drivers.serial.boards.turning import Turning

FASTEST_HZ = 50_000
"""No such board counts more edges in a second."""

WRAPS_AT = 2**32
"""A count has 32 bits."""


class Counts:
    """Adds up a wheel's counts; one that the wheel cannot have come to by now counts only if the next one confirms it.

    Then the board has begun to count anew, and what the wheel turned meanwhile is not known.
    """

    def __init__(self) -> None:
        self.turning = Turning(WRAPS_AT)
        self._last: tuple[int, float] | None = None
        self._doubted: tuple[int, float] | None = None

    def take(self, count: int, time: float) -> None:
        """Take what the board has counted."""
        if self._last and not _follows(count, time, *self._last):
            if not (self._doubted and _follows(count, time, *self._doubted)):
                self._doubted = count, time
                return
            self.turning.restart()
        self._last, self._doubted = (count, time), None
        self.turning.count(count, time)

    def restart(self) -> None:
        """Know that the board may count from anywhere now."""
        self._last = self._doubted = None
        self.turning.restart()


def _follows(count: int, time: float, before: int, then: float) -> bool:
    turned = (count - before + WRAPS_AT // 2) % WRAPS_AT - WRAPS_AT // 2
    return abs(turned) <= math.ceil((time - then) * FASTEST_HZ)
