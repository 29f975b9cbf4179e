"""A monitor of the app's steps that wait, as in ``time.sleep``."""

from __future__ import annotations

from collections.abc import Callable

from robotcore.hal.wall_clock import read_idle_time, read_queue_time

MAX_WAIT_S = 1.0
"""The longest time that the steps of a run may wait without a note, in seconds."""

MAX_WAIT_SHARE = 1.5
"""The longest time that the steps may wait without a note, as a multiple of the simulated time."""


class WaitMonitor:
    """Measures how long the app's steps wait, as in ``time.sleep``, and reports a long time once.

    A simulation does not advance during a step. So an app that waits drives nowhere, or its run takes very long. The
    time in which the step uses the processor does not count. The time for which the thread of the run has waited for a
    busy processor is subtracted, also if it was outside the steps.

    report: a function that gets the note.
    """

    def __init__(self, report: Callable[[str], object]) -> None:
        self._report = report
        self._waited_s = self._idle_s = 0.0
        self._queue_s = read_queue_time()
        self._has_reported = False

    def begin(self) -> None:
        """Record the beginning of a step."""
        self._idle_s = read_idle_time()

    def end(self, now: float) -> None:
        """Record the end of a step.

        now: the simulated time, in seconds.
        """
        self._waited_s += read_idle_time() - self._idle_s
        limit_s = max(MAX_WAIT_S, MAX_WAIT_SHARE * now)
        if self._has_reported or self._waited_s <= limit_s:
            return
        waited_s = self._waited_s - (read_queue_time() - self._queue_s)
        if waited_s > limit_s:
            self._has_reported = True
            self._report(
                f"the app's steps have waited for {waited_s:.1f} s, and {now:.1f} s have passed in the "
                "simulation, which does not advance during a step. Do not sleep in step: return Status.RUNNING, and "
                "compare robot.clock.now() in a later tick"
            )
