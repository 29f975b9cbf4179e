"""How far a sweep is, on a terminal."""

from __future__ import annotations

import sys
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from robotcore.sweep.record import Record

_MEMORY_S = 600.0
"""The time left is reckoned from so many of the last seconds: slow runs and quick ones take turns."""


class SweepProgress:
    """A bar on stderr while it is entered, gone after it; nothing where stderr is no terminal."""

    def __init__(self, total: int, done: int, failing: int) -> None:
        self._failing = failing
        self._bar = Progress(
            BarColumn(bar_width=None),
            MofNCompleteColumn(),
            TextColumn("{task.fields[failing]} failing"),
            TimeRemainingColumn(),
            console=Console(stderr=True, highlight=False),
            transient=True,
            speed_estimate_period=_MEMORY_S,
            disable=not (sys.stderr and sys.stderr.isatty()),
        )
        self._task = self._bar.add_task("", total=total, completed=done, failing=failing)

    def __enter__(self) -> SweepProgress:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._bar.stop()

    def show(self, record: Record) -> None:
        """Count one run more."""
        self._failing += record.is_failure
        self._bar.update(self._task, advance=1, failing=self._failing)
