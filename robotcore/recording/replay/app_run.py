"""Run an app on the samples of a recording."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from robotcore.errors import Interrupted, RecordingError
from robotcore.recording import Recording
from robotcore.recording.replay.tick_reader import TickReader
from robotcore.runtime.layers.base import Tap
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Run, run
from robotcore.runtime.trace import TickRecord

BACKEND = "replay"


class ReplayTap(Tap, ABC):
    """A tap and an observer that compares each tick of a run on a recording with the recorded tick."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.current = TickReader(recording.ticks[0])
        """The recorded tick that is compared with the current tick of the run."""

    def begin(self, run: Run) -> None:
        """Do nothing. The comparison begins with the first tick."""

    @abstractmethod
    def tick(self, record: TickRecord) -> None:
        """Compare a tick with the recorded one."""

    def end(self, result: RunResult) -> None:
        """Do nothing. The result is compared after the run."""

    def advance(self, ticks: int) -> None:
        """Continue with the next recorded tick, if there is one, after this number of ticks."""
        if ticks < len(self.recording.ticks):
            self.current = TickReader(self.recording.ticks[ticks])


def require_ticks(recording: Recording, file: Path | str) -> None:
    """Raise RecordingError if a recording has no tick."""
    if not recording.ticks:
        raise RecordingError(
            file or "the recording", "no tick was recorded", "Record another run", kind="recording-without-tick"
        )


def run_app(tap: ReplayTap, app: str | None, settings: Mapping[str, Any], *, is_held: bool = False) -> RunResult:
    """Run an app on the recording of a tap, and return the result. Raises the error of a run without a tick.

    app: the name or the file of the app; None for the recorded app.
    is_held: whether the replay backend keeps the safety rules of the recorded run, see `ReplayOptions`.
    """
    recorded = tap.recording.metadata.request
    request = RunRequest(
        app=app or recorded.app_reference,
        backend=BACKEND,
        seed=recorded.seed,
        rate_hz=recorded.rate_hz,
        timeout_s=recorded.timeout_s,
        settings=settings,
        options={"recording": tap.recording, "is_held": is_held},
    )
    result = run(request, [tap], [tap])
    if result.error and not isinstance(result.error, Interrupted) and not result.ticks:
        raise result.error
    return result
