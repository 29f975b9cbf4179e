"""Find the tick at which a ring recording begins for its readers."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from robotcore.recording.events import SampleKey
    from robotcore.recording.tap import TickEvents


class CompleteTicks:
    """The ticks of a ring recording, with the times of their samples.

    A tick can read a sample that an earlier tick has read. If the ring has deleted the sample, the reader leaves out
    both ticks.
    """

    def __init__(self) -> None:
        self._written: dict[SampleKey, float] = {}
        """The times at which the newest sample of each device and the samples of the newest tick were written."""
        self._ticks: deque[tuple[float, float]] = deque()
        """The time of each tick, and the time at which its oldest sample was written."""

    def add(self, time: float, events: TickEvents, dropped_until_s: float | None) -> None:
        """Add the next tick, and delete the first ticks that lack a sample.

        time: the time of the tick, in seconds.
        dropped_until_s: the time of the last deleted message in seconds; None if there is none.
        """
        newest = {key.device: (key, written) for key, written in self._written.items()}
        self._written = dict(newest.values()) | {key: time for key, _ in events.samples}
        keys = (read.key for read in events.reads if read.key)
        self._ticks.append((time, min((self._written.get(key, 0.0) for key in keys), default=time)))
        if dropped_until_s is not None:
            self.find_begin(dropped_until_s)

    def find_begin(self, dropped_until_s: float) -> float:
        """Delete the first ticks that lack a sample. Return the time of the first tick that remains, in seconds.

        dropped_until_s: the time of the last deleted message in seconds, which is returned if no tick remains.
        """
        while self._ticks and self._ticks[0][1] <= dropped_until_s:
            self._ticks.popleft()
        return self._ticks[0][0] if self._ticks else dropped_until_s
