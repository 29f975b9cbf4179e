from __future__ import annotations

import io
import re
from contextlib import nullcontext
from dataclasses import replace

import pytest
from rich.console import Console

from robotcore import RunRequest, run
from robotcore.geometry import Wheels
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.range_sensor import Range, RangeSensor
from robotcore.runtime.session import RunContext
from robotcore.runtime.trace import MonitoredValue, TickRecord
from robotcore.safety.velocity_limits import Intervention
from robotcore.view.progress import ProgressLine
from tests.texts import CheckText

REQUEST = RunRequest("avoid-obstacles", world="open", settings={"duration_s": 0.5})


class RecordedProgressLine(ProgressLine):
    """A progress line that stores its text at each tick."""

    def __init__(self) -> None:
        self.console = Console(file=io.StringIO(), force_terminal=True, width=160)
        self.lines: list[str] = []
        super().__init__(self.console, lambda: "space: stop")
        self._live.auto_refresh = False  # its thread would write into the captured lines

    def begin(self, run: RunContext) -> None:
        self.last_run = run
        super().begin(run)

    def tick(self, record: TickRecord) -> None:
        super().tick(record)
        with self.console.capture() as capture:
            self.console.print(self._build_line())
        self.lines.append(capture.get())


def columns(line: str) -> list[str]:
    """Return the columns of a line, without the spinner and the escape sequences."""
    return re.split(r"\s{2,}", re.sub(r"\x1b\[[\d;]*m", "", line).strip())[1:]


def run_line() -> RecordedProgressLine:
    """Return the line of a short run, which further ticks can change."""
    progress = RecordedProgressLine()
    run(REQUEST, [progress])
    progress._run = progress.last_run
    return progress


def render_below(progress: RecordedProgressLine) -> list[str]:
    """Return the texts below the line."""
    with progress.console.capture() as capture:
        progress.console.print(progress._build_lines())
    return re.sub(r"\x1b\[[\d;]*m", "", capture.get()).splitlines()[1:]


def test_the_line_has_app_backend_state_range_time_and_pace(check_text: CheckText) -> None:
    *before, pace, hint = columns(run_line().lines[-1])
    check_text("\n".join([*before, hint]))
    check_text(re.sub(r"[\d.]+", "1.0", pace))


def test_the_line_of_a_paused_run_says_so() -> None:
    progress = run_line()
    assert progress.last_run.pace
    progress.last_run.pace.pause()
    progress.tick(TickRecord(11, 0.55, "cruise", None, None, ()))
    assert "paused" in columns(progress.lines[-1])


def test_the_line_of_a_real_robot_has_its_last_range_and_no_pace(
    monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    progress = run_line()
    sensor = next(each for each in progress.last_run.robot.devices.values() if isinstance(each, RangeSensor))
    monkeypatch.setattr(sensor, "latest", Range(0.84, 0.0, 0))
    clock = progress.last_run.robot.clock = MonotonicClock()
    progress.tick(TickRecord(11, 0.55, "cruise", None, None, ()))
    clock.close()
    check_text("\n".join(columns(progress.lines[-1])))


def test_voltage_warnings_and_escapes_are_shown() -> None:
    progress = run_line()
    monitored = {"cells": MonitoredValue(6.214, "V")}
    record = TickRecord(11, 0.55, "\x1b]0;title\x07", None, None, (), monitored=monitored, warnings=("\x1b[2J",))
    progress.tick(record)
    progress.tick(record._replace(warnings=()))
    assert "6.21 V" in progress.lines[-1]
    assert "\\x1b]0;title\\x07" in progress.lines[-1]
    assert render_below(progress) == ["  warning: \\x1b[2J"]


def test_the_line_has_the_active_faults() -> None:
    progress = RecordedProgressLine()
    fault = "range noise=0.01 after=0.2 lasts=0.2"
    run(replace(REQUEST, faults=(fault,)), [progress])
    assert [fault in line for line in progress.lines] == [4 <= tick < 8 for tick in range(11)]


def test_the_interventions_so_far_follow_below_the_line(check_text: CheckText) -> None:
    progress = run_line()
    forward, stopped, below = Wheels(5.0, 5.0), Wheels(0.0, 0.0), []
    for tick in range(12, 24):
        guard = Intervention(tick / 20, "range guard", forward, stopped)
        progress.tick(TickRecord(tick, tick / 20, "cruise", forward, stopped, (guard,)))
        below.append(render_below(progress))
    assert below[:10] == [[]] * 10
    check_text("\n".join(line for lines in below[10:] for line in lines))


@pytest.mark.parametrize("is_broken", [False, True])
def test_after_a_run_the_line_is_gone_and_the_cursor_is_shown(
    monkeypatch: pytest.MonkeyPatch, *, is_broken: bool
) -> None:
    progress = RecordedProgressLine()
    if is_broken:
        monkeypatch.setattr(progress, "tick", lambda _: int("an error"))
    with pytest.raises(ValueError, match="an error") if is_broken else nullcontext():
        run(REQUEST, [progress])
    progress.close()
    written = progress.console.file.getvalue()  # type: ignore[attr-defined]  # the file is ours
    assert written.rindex("\x1b[?25h") > written.rindex("\x1b[?25l")
    assert not progress._live.is_started
