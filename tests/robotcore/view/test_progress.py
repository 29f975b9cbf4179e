from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from dataclasses import replace

import pytest
from rich.console import Console

from robotcore import RunRequest, run
from robotcore.geometry import Wheels
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord
from robotcore.safety import Intervention
from robotcore.view.progress import ProgressLine
from tests.texts import CheckText

REQUEST = RunRequest("avoid-obstacles", world="open", settings={"duration_s": 0.5})


class RecordedProgressLine(ProgressLine):
    """A progress line that stores its text at each tick."""

    def __init__(self, hint: Callable[[], str] = str) -> None:
        self.console = Console(file=io.StringIO(), force_terminal=True, width=160)
        self.lines: list[str] = []
        super().__init__(self.console, hint)

    def begin(self, run: Run) -> None:
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


def test_the_line_has_app_backend_state_range_time_and_pace(check_text: CheckText) -> None:
    progress = RecordedProgressLine()
    run(REQUEST, [progress])
    *before, pace = columns(progress.lines[-1])
    check_text("\n".join(before))
    check_text(re.sub(r"[\d.]+", "1.0", pace))


def test_control_characters_of_a_state_and_of_a_warning_are_escaped() -> None:
    progress = RecordedProgressLine()
    run(REQUEST, [progress])
    progress._run = progress.last_run
    progress.tick(TickRecord(11, 0.55, "\x1b]0;title\x07", None, None, (), warnings=("\x1b[2J",)))
    with progress.console.capture() as capture:
        progress.console.print(progress._build_lines())
    output = capture.get()
    assert "\\x1b]0;title\\x07" in output
    assert "\\x1b[2J" in output


def test_the_line_of_a_real_robot_has_no_pace() -> None:
    progress = RecordedProgressLine()
    run(REQUEST, [progress])
    clock = progress.last_run.robot.clock = MonotonicClock()
    progress._run = progress.last_run
    progress.tick(TickRecord(11, 0.55, "cruise", None, None, ()))
    clock.close()
    assert columns(progress.lines[-1])[-1] == "0.6 s"


@pytest.mark.parametrize("distance", [0.84, math.inf])
def test_the_line_has_the_last_range(monkeypatch: pytest.MonkeyPatch, distance: float, check_text: CheckText) -> None:
    progress = RecordedProgressLine()
    run(REQUEST, [progress])
    sensor = next(each for each in progress.last_run.robot.devices.values() if isinstance(each, RangeSensor))
    monkeypatch.setattr(sensor, "latest", Range(distance, 0.0, 0))
    progress._run = progress.last_run
    progress.tick(TickRecord(11, 0.55, "cruise", None, None, ()))
    check_text(columns(progress.lines[-1])[2])


def test_the_line_has_the_voltage_and_the_warnings_follow_below(check_text: CheckText) -> None:
    progress = RecordedProgressLine()
    run(REQUEST, [progress])
    progress._run = progress.last_run
    record = TickRecord(11, 0.55, "cruise", None, None, (), voltages={"cells": 6.214}, warnings=("cells: charge it",))
    progress.tick(record)
    progress.tick(record._replace(warnings=()))
    assert "6.21 V" in progress.lines[-1]
    with progress.console.capture() as capture:
        progress.console.print(progress._build_lines())
    check_text(re.sub(r"\x1b\[[\d;]*m", "", capture.get()).splitlines()[1])


def test_the_line_has_the_active_faults() -> None:
    progress = RecordedProgressLine()
    fault = "range noise=0.01 after=0.2 lasts=0.2"
    run(replace(REQUEST, faults=(fault,)), [progress])
    assert [fault in line for line in progress.lines] == [4 <= tick < 8 for tick in range(11)]


def test_the_interventions_so_far_follow_below_the_line(check_text: CheckText) -> None:
    progress = RecordedProgressLine()
    run(REQUEST, [progress])
    progress._run = progress.last_run
    forward, stopped, below = Wheels(5.0, 5.0), Wheels(0.0, 0.0), []
    for tick in range(12, 24):
        time = tick / 20
        guard = Intervention(time, "range guard", forward, stopped)
        progress.tick(TickRecord(tick, time, "cruise", forward, stopped, (guard,)))
        with progress.console.capture() as capture:
            progress.console.print(progress._build_lines())
        below.append(re.sub(r"\x1b\[[\d;]*m", "", capture.get()).splitlines()[1:])
    assert below[:10] == [[]] * 10
    check_text("\n".join(line for lines in below[10:] for line in lines))


def test_the_line_ends_with_the_newest_hint() -> None:
    hints = iter(["space: stop", *[""] * 5, *["space: stop"] * 5])
    progress = RecordedProgressLine(lambda: next(hints))
    progress._live.auto_refresh = False
    run(REQUEST, [progress])
    assert ["space: stop" in line for line in progress.lines] == [True, *[False] * 5, *[True] * 5]


def test_the_line_ends_if_the_run_raises() -> None:
    class BrokenProgressLine(RecordedProgressLine):
        def begin(self, run: Run) -> None:
            super().begin(run)
            raise ArithmeticError

    progress = BrokenProgressLine()
    with pytest.raises(ArithmeticError):
        run(REQUEST, [progress])
    progress.close()
    assert not progress._live.is_started


def test_after_a_run_the_line_is_gone_and_the_cursor_is_shown() -> None:
    progress = RecordedProgressLine()
    run(REQUEST, [progress])
    written = progress.console.file.getvalue()  # type: ignore[attr-defined]  # the file is ours
    assert written.rindex("\x1b[?25h") > written.rindex("\x1b[?25l")
    assert not progress._live.is_started
