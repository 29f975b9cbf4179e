"""Where a robot went, at the grain that is worth keeping of thousands of runs."""

from __future__ import annotations

from robotcore.hal.truth import Truth
from robotcore.runtime.outcome import RunResult
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord
from robotcore.sweep.record import TruePath

INTERVAL_S = 0.5
_EARLY_S = 1e-6
"""A tick's time is a sum of steps, and may come out this much early."""


class PathRecorder:
    """An observer: the true place every half a second, to the millimetre."""

    def __init__(self) -> None:
        self._truth: Truth | None = None
        self._points: list[tuple[float, float, float]] = []

    @property
    def path(self) -> TruePath | None:
        """The path so far; None where nobody knows the true pose."""
        return tuple(self._points) if self._truth else None

    def begin(self, run: Run) -> None:
        self._truth = run.truth

    def tick(self, record: TickRecord) -> None:
        if self._truth and record.time + _EARLY_S >= len(self._points) * INTERVAL_S:
            pose = self._truth.pose
            self._points.append((round(record.time, 3), round(pose.x, 3), round(pose.y, 3)))

    def end(self, result: RunResult) -> None:
        pass
