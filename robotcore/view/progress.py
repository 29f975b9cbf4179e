"""The progress line of a run in a terminal."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite

from rich.console import Console, Group
from rich.live import Live
from rich.spinner import Spinner
from rich.table import Table
from rich.text import Text

from robotcore.hal.robot import Role
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.intervention_timer import InterventionTimer
from robotcore.runtime.layers.devices import AppSensor
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import RunContext
from robotcore.runtime.trace import TickRecord, format_monitored
from robotcore.text import escape
from robotcore.view.text import list_interventions

REFRESH_HZ = 10
"""The rate at which the line is drawn."""


class ProgressLine:
    """An observer that shows a line during a run: state, range, monitored values, time, pace, active faults and a hint.

    `tick` only stores the record of the tick and measures the interventions. A thread draws the newest record. The
    run's interventions and warnings follow below the line.
    """

    def __init__(self, console: Console | None = None, hint: Callable[[], str] = str) -> None:
        """Prepare the line. It appears when the run begins.

        console: where to draw; None for stderr.
        hint: a function that returns the text at the end of the line. It is called each time the line is drawn.
        """
        self._hint = hint
        self._spinner = Spinner("dots")
        self._wall = MonotonicClock()
        self._run: RunContext | None = None
        self._record: TickRecord | None = None
        self._warnings: list[str] = []
        self._timer = InterventionTimer()
        console = console or Console(stderr=True, highlight=False, markup=False, emoji=False)
        self._live = Live(
            get_renderable=self._build_lines, console=console, refresh_per_second=REFRESH_HZ, transient=True
        )

    def begin(self, run: RunContext) -> None:
        self._wall = MonotonicClock()
        self._run = run
        self._live.start()

    def tick(self, record: TickRecord) -> None:
        self._record = record
        self._timer.add(record)
        self._warnings += record.warnings

    def end(self, result: RunResult) -> None:
        self.close()

    def close(self) -> None:
        """Remove the line. Later calls do nothing."""
        self._run = None
        self._live.stop()

    def pause(self) -> None:
        """Hide the line until `resume` is called."""
        self._live.stop()

    def resume(self) -> None:
        """Show the line again if it was visible before."""
        if self._run:
            self._live.start()

    def _build_lines(self) -> Group:
        interventions = (Text(f"  {escape(each)}", "yellow") for each in list_interventions(self._timer.measure()))
        warnings = (Text(f"  warning: {escape(each)}", "yellow") for each in self._warnings)
        return Group(self._build_line(), *interventions, *warnings)

    def _build_line(self) -> Table:
        line = Table.grid(padding=(0, 2))
        if self._run and self._record:
            request, record = self._run.request, self._record
            line.add_row(
                self._spinner,
                escape(f"{request.app_reference} on {request.backend}"),
                escape(record.status_text),
                _format_last_range(self._run),
                format_monitored(record.monitored),
                f"{record.time:.1f} s",
                self._format_pace(record, self._run),
                _format_faults(self._run, record.time),
                self._hint(),
            )
        return line

    def _format_pace(self, record: TickRecord, run: RunContext) -> str:
        """Return the ratio of simulated to real time, such as ``2.0x real time``; empty on a real robot.

        It is ``paused`` in a pause.
        """
        if run.pace and run.pace.is_paused:
            return "paused"
        if isinstance(run.robot.clock, MonotonicClock):
            return ""
        return f"{record.time / max(self._wall.now(), 1e-3):.1f}x real time"


def _format_faults(run: RunContext, time: float) -> str:
    return "; ".join(str(fault) for fault in run.faults if fault.is_active(time))


def _format_last_range(run: RunContext) -> str:
    sensor = run.robot.range if run.robot.has(Role.RANGE) else None
    if not isinstance(sensor, AppSensor) or (sample := sensor.latest) is None:
        return ""
    return f"{sample.distance:.2f} m ahead" if isfinite(sample.distance) else "nothing ahead"
