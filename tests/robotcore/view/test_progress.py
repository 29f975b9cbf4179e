from __future__ import annotations

import io
import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from rich.console import Console

from robotcore import RunRequest, run
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord
from robotcore.view.progress import Progress

REQUEST = RunRequest("avoid-obstacles", world="open", settings={"duration_s": 0.5})


class Painted(Progress):
    """Draws its line at each tick too, and keeps what was on it."""

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
            self.console.print(self._line())
        self.lines.append(capture.get())


def test_the_line_tells_app_backend_state_and_time() -> None:
    progress = Painted()
    run(REQUEST, [progress])
    assert "avoid-obstacles on kinematic" in progress.lines[-1]
    assert "cruise" in progress.lines[-1]
    assert "0.5 s" in progress.lines[-1]
    assert "x real time" in progress.lines[-1]


def test_control_characters_of_a_state_and_of_a_warning_are_escaped() -> None:
    progress = Painted()
    run(REQUEST, [progress])
    progress._run = progress.last_run
    progress.tick(TickRecord(11, 0.55, "\x1b]0;title\x07", None, None, (), warnings=("\x1b[2J",)))
    with progress.console.capture() as capture:
        progress.console.print(progress._lines())
    assert "\\x1b]0;title\\x07" in capture.get()
    assert "warning: \\x1b[2J" in capture.get()


def test_on_a_robot_no_pace_is_reported_for_it_has_none_but_its_own() -> None:
    progress = Painted()
    run(REQUEST, [progress])
    clock = progress.last_run.robot.clock = MonotonicClock()
    progress._run = progress.last_run
    progress.tick(TickRecord(11, 0.55, "cruise", None, None, ()))
    clock.close()
    assert "real time" not in progress.lines[-1]


@pytest.mark.parametrize("distance, words", [(0.84, "0.84 m ahead"), (math.inf, "nothing ahead")])
def test_the_line_tells_the_range_that_was_read(monkeypatch: pytest.MonkeyPatch, distance: float, words: str) -> None:
    progress = Painted()
    run(REQUEST, [progress])
    sensor = next(each for each in progress.last_run.robot.devices.values() if isinstance(each, RangeSensor))
    monkeypatch.setattr(sensor, "latest", Range(distance, 0.0, 0))
    progress._run = progress.last_run
    progress.tick(TickRecord(11, 0.55, "cruise", None, None, ()))
    assert words in progress.lines[-1]


def test_the_line_tells_the_voltage_and_below_it_stands_what_was_warned_of() -> None:
    progress = Painted()
    run(REQUEST, [progress])
    progress._run = progress.last_run
    record = TickRecord(11, 0.55, "cruise", None, None, (), voltages={"cells": 6.214}, warnings=("cells: charge it",))
    progress.tick(record)
    progress.tick(record._replace(warnings=()))
    assert "6.21 V" in progress.lines[-1]
    with progress.console.capture() as capture:
        progress.console.print(progress._lines())
    assert "warning: cells: charge it" in capture.get()


def test_the_line_tells_the_faults_that_are_there() -> None:
    progress = Painted()
    fault = "range noise=0.01 after=0.2 lasts=0.2"
    run(replace(REQUEST, faults=(fault,)), [progress])
    assert [fault in line for line in progress.lines] == [4 <= tick < 8 for tick in range(11)]


def test_the_line_ends_in_the_hint_of_that_moment() -> None:
    hints = iter(["space: stop", *[""] * 5, *["space: stop"] * 5])
    progress = Painted(lambda: next(hints))
    progress._live.auto_refresh = False
    run(REQUEST, [progress])
    assert ["space: stop" in line for line in progress.lines] == [True, *[False] * 5, *[True] * 5]


def test_nothing_is_left_running_when_the_run_raises() -> None:
    class Breaking(Painted):
        def begin(self, run: Run) -> None:
            super().begin(run)
            raise RuntimeError("an observer's bug")

    progress = Breaking()
    with pytest.raises(RuntimeError, match="bug"):
        run(REQUEST, [progress])
    progress.close()
    assert not progress._live.is_started


def test_a_run_leaves_no_line_and_gives_the_cursor_back() -> None:
    progress = Painted()
    run(REQUEST, [progress])
    written = progress.console.file.getvalue()  # type: ignore[attr-defined]  # the file is ours
    assert written.rindex("\x1b[?25h") > written.rindex("\x1b[?25l")
    assert not progress._live.is_started
