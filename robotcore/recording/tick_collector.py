"""Collects the entries of a run, one in each tick: for a file, or for the clients of a server."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress

from robotcore.errors import Interrupted, RobotcoreError
from robotcore.recording.events import GroundTruthSample, RecordedError
from robotcore.recording.tap import RecordingTap
from robotcore.recording.writer import Entry
from robotcore.runtime.observer import RunContext
from robotcore.runtime.trace import TickRecord


class TickCollector:
    """Collects the events, the true pose and the error of each tick.

    has_room: a function that returns whether a new picture is kept. Otherwise it is dropped.
    """

    def __init__(self, has_room: Callable[[], bool]) -> None:
        self.layer = RecordingTap(has_room)
        """The layer of the run that records the calls of the app."""
        self._run: RunContext | None = None
        self._outer: BaseException | None = None

    def begin(self, run: RunContext) -> None:
        """Begin a run."""
        self._run, self._outer = run, sys.exc_info()[1]

    def collect(self, record: TickRecord) -> Entry:
        """Return the entry of a tick that has ended."""
        return Entry(record, self.layer.take(), self._read_truth(record), self._find_error(record))

    def _find_error(self, record: TickRecord) -> RecordedError | None:
        """Return the error that ends the run in this tick; None if the run continues.

        The loop calls `tick` while it handles the error, so ``sys.exc_info`` has it. The latch's error has precedence.
        """
        error = self.layer.find_latched(record.interventions) or sys.exc_info()[1]
        if error is self._outer or not isinstance(error, (RobotcoreError, Interrupted)):
            return None
        return RecordedError.from_error(error)

    def _read_truth(self, record: TickRecord) -> GroundTruthSample | None:
        if self._run and (truth := self._run.truth):
            with suppress(RobotcoreError):  # the simulator may have died
                return GroundTruthSample(record.tick, record.time, truth.pose, truth.contacts)
        return None
