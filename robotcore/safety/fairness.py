"""Time that counts against somebody: not the time in which the machine did not let him go on."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from robotcore.hal.wall_clock import MonotonicClock

LATE = 2.0
"""Whoever looks this many times later than he meant to was held up himself: what is over that does not count."""


class FairTime:
    """Counts the seconds of a thread that is looked at every ``period_s``.

    What does not count: where the system tells (Linux), the time in which the thread was ready to run and had no
    processor, the second figure of ``schedstat`` (https://docs.kernel.org/scheduler/sched-stats.html); everywhere, the
    time for which whoever looks was held up, as he is when the process was suspended or another thread kept the
    interpreter's lock.
    """

    def __init__(self, native_thread: int, period_s: float) -> None:
        self._file = Path(f"/proc/self/task/{native_thread}/schedstat")
        self._longest = LATE * period_s
        self._wall = MonotonicClock()
        self._last = 0.0
        self._waited = self._waiting_time()

    def passed(self) -> float:
        """Return the seconds that count since this was last asked."""
        now = self._wall.now()
        elapsed, self._last = min(now - self._last, self._longest), now
        waiting = self._waiting_time()
        waited = max(0.0, min(waiting - self._waited, elapsed))
        self._waited += waited  # of a longer wait the rest counts next time
        return elapsed - waited

    def _waiting_time(self) -> float:
        """Return for how long the thread has waited for a processor in its life, in seconds."""
        with suppress(OSError, ValueError, IndexError):
            return int(self._file.read_text().split()[1]) * 1e-9
        return 0.0
