"""Record runs in memory, without a file."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

from robotcore.errors import Interrupted, RobotcoreError
from robotcore.recording import GroundTruthSample, Metadata, RecordedError, RecordedSample, Recording, SampleKey, Tick
from robotcore.recording.recording import build_metadata
from robotcore.recording.tap import RecordingTap
from robotcore.recording.writer import TickBuilder
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Run, RunRequest, run
from robotcore.runtime.trace import TickRecord


class Memory:
    """An observer that collects the events of its recording layer."""

    def __init__(self) -> None:
        self.layer = RecordingTap(lambda: True)
        self.ticks: list[Tick] = []
        self.samples: dict[SampleKey, RecordedSample] = {}
        self.truth: list[GroundTruthSample] = []
        self.about: Metadata | None = None
        self.result: RunResult | None = None
        self._run: Run | None = None
        self._ticks: TickBuilder | None = None

    def begin(self, run: Run) -> None:
        self._run, self.about = run, build_metadata(run)
        self._ticks = TickBuilder(run.description)

    def tick(self, record: TickRecord) -> None:
        notes, error = self.layer.take(), self.layer.find_latched(record.interventions) or sys.exc_info()[1]
        self.samples |= dict(notes.samples)  # type: ignore[arg-type]  # samples of ours are recorded ones
        assert self._ticks, "a run has begun"
        raised = RecordedError.of(error) if isinstance(error, (RobotcoreError, Interrupted)) else None
        self.ticks.append(self._ticks.build(record, notes, raised))
        if self._run and self._run.truth:
            truth = self._run.truth
            self.truth.append(GroundTruthSample(record.tick, record.time, truth.pose, truth.contacts))

    def end(self, result: RunResult) -> None:
        self.result = result

    @property
    def recording(self) -> Recording:
        assert self.about, "a run has begun"
        return Recording(self.about, self.ticks, self.samples, self.result, self.truth)


def record_run(app: str = "green-search", *, disturbance: Any = None, **asked: Any) -> Recording:
    """Run an app, and return its recording.

    disturbance: an observer and layer below the recording layer, which disturbs the run.
    """
    memory = Memory()
    others = [disturbance] if disturbance else []
    run(RunRequest(app, **asked), [memory, *others], [*others, memory.layer])
    return memory.recording


def change_tick(recording: Recording, number: int, **changes: Any) -> Recording:
    """Return the recording with one changed tick."""
    ticks = [replace(tick, **changes) if tick.number == number else tick for tick in recording.ticks]
    return replace(recording, ticks=ticks)
