"""A call that may hang, in a thread of its own, so that whoever needs it done is not held up for long."""

from __future__ import annotations

from collections.abc import Callable
from threading import Thread

from robotcore.clock import MonotonicClock


class Errand:
    """Calls ``work`` in a thread of its own, from now on; ``failure`` is what it raised."""

    def __init__(self, name: str, work: Callable[[], object]) -> None:
        self.failure: Exception | None = None
        self._work, self._wall = work, MonotonicClock()
        self._thread = Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def is_under_way(self) -> bool:
        return self._thread.is_alive()

    def is_done_within(self, limit_s: float) -> bool:
        """Wait for the end, until this long after the beginning; return whether it has come."""
        self._thread.join(max(0.0, limit_s - self._wall.now()))
        return not self._thread.is_alive()

    def _run(self) -> None:
        try:
            self._work()
        except Exception as failure:  # noqa: BLE001  whoever sent it asks
            self.failure = failure
