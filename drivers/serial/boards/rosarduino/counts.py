"""Counts that can be: a lost digit makes another number, and a board that was reset says nothing of it."""

from __future__ import annotations

import math

from drivers.serial.boards.turning import Turning

FASTEST_HZ = 50_000
"""No such board counts more edges in a second."""

MISSED_S = 0.05
"""After a pause of so long an answer was lost: a board that was reset takes longer to begin anew."""

WRAPS_AT = 2**32
"""A count has 32 bits."""


class Counts:
    """Adds up a wheel's counts, but for those that it cannot have come to.

    One that is too far from the last counts only if the next one confirms it. One that after a pause is nearer to zero
    than to the last is of a board that was reset. Nobody knows what the wheel turned meanwhile, and nothing is added.
    """

    def __init__(self) -> None:
        self.turning = Turning(WRAPS_AT)
        self._last: tuple[int, float] | None = None
        self._doubted: tuple[int, float] | None = None

    def take(self, count: int, time: float) -> None:
        """Take what the board has counted."""
        if self._last and _was_reset(count, time, *self._last):
            self.restart()
        elif self._last and not _follows(count, time, *self._last):
            if not (self._doubted and _follows(count, time, *self._doubted)):
                self._doubted = count, time
                return
            self.restart()
        self._last, self._doubted = (count, time), None
        self.turning.count(count, time)

    def restart(self) -> None:
        """Know that the board may count from anywhere now."""
        self._last = self._doubted = None
        self.turning.restart()


def _was_reset(count: int, time: float, before: int, then: float) -> bool:
    return time - then > MISSED_S and abs(count) < abs(_turned(count, before))


def _follows(count: int, time: float, before: int, then: float) -> bool:
    return abs(_turned(count, before)) <= math.ceil((time - then) * FASTEST_HZ)


def _turned(count: int, before: int) -> int:
    return (count - before + WRAPS_AT // 2) % WRAPS_AT - WRAPS_AT // 2
