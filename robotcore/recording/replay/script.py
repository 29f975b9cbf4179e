"""A recording as a script: where its replay stands, and where it left it."""

from __future__ import annotations

from typing import NoReturn

from robotcore.errors import DeviationError, RecordingEndedError, RobotcoreError
from robotcore.recording import Recording
from robotcore.recording.replay.cues import Cues
from robotcore.recording.replay.deviation import Deviation
from robotcore.runtime.trace import TickRecord, Trace


class Script:
    """The ticks of a recording, one after the other; ``compared`` of them were found equal, ``trace`` adds them up.

    What ended the replay is raised at every `check` from then on, whatever an app catches.
    """

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.cues = Cues(recording.ticks[0])
        self.deviation: Deviation | None = None
        self.trace = Trace(())
        self._ended_by: RobotcoreError | None = None

    @property
    def compared(self) -> int:
        return self.trace.ticks

    @property
    def is_at_end(self) -> bool:
        """Whether the recording was cut short in this tick, and the app asked for what it does not have."""
        return isinstance(self._ended_by, RecordingEndedError)

    def check(self) -> None:
        """Raise what ended the replay, if something did."""
        if self._ended_by:
            raise self._ended_by

    def deviate(self, what: str, recorded: str, replayed: str) -> NoReturn:
        """Note what differs in this tick, and raise DeviationError; the first one stays."""
        self.check()
        self.deviation = Deviation.of(self.cues.tick, what, recorded, replayed, self.recording.samples)
        self._end_by(DeviationError(str(self.deviation)))

    def lack(self, what: str, recorded: str, replayed: str) -> NoReturn:
        """Deviate by what the recording does not have; where it was cut short in this tick, it ends instead."""
        if self.cues.is_cut_short:
            self.end()
        self.deviate(what, recorded, replayed)

    def end(self) -> NoReturn:
        """Raise RecordingEndedError: the recording was cut short in this tick."""
        self.check()
        self._end_by(RecordingEndedError(self.compared, self.cues.tick.time))

    def go_on(self, record: TickRecord) -> None:
        """Count this tick as equal, and turn to the next."""
        self.trace.add(record)
        if self.compared < len(self.recording.ticks):
            self.cues = Cues(self.recording.ticks[self.compared])

    def _end_by(self, error: RobotcoreError) -> NoReturn:
        self._ended_by = error
        raise error
