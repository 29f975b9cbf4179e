"""test_evaluation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from robotcore.errors import UnmetNeedError
from robotcore.recording import Recording
from robotcore.recording.replay import Evaluation, evaluate
from robotcore.runtime.result import Outcome
from robotcore.view.text import format_replay
from tests.robotcore.recording.replay.memory import recorded
from tests.texts import Raises

APPS = str(Path(__file__).parent / "recorded_apps.py")


@pytest.fixture(scope="module")
def search() -> Recording:
    return recorded("green-search", seed=7, timeout_s=8.0)


def test_the_same_app_decides_the_same_behind_its_own_safety_stage(search: Recording) -> None:
    rehearsed = evaluate(search)
    assert (rehearsed.first_difference, rehearsed.differing) == (None, 0)
    assert rehearsed.ticks == len(search.ticks)
    assert search.result
    assert rehearsed.result.trace_sha256 == search.result.trace_sha256


def test_another_setting_parts_where_it_first_matters(search: Recording) -> None:
    rehearsed = evaluate(search, settings={"speed_m_s": "0.1"})
    first_difference = rehearsed.first_difference
    assert first_difference
    assert first_difference.what == "the command"
    assert first_difference.tick > 0
    assert 0 < rehearsed.differing <= rehearsed.ticks
    assert rehearsed.exit_status == 0


def test_app_that_goes_on_is_no_error_where_the_recording_ends(search: Recording) -> None:
    rehearsed = evaluate(replace(search, ticks=search.ticks[:50]), settings={"speed_m_s": 0.1})
    assert (rehearsed.is_at_end, rehearsed.exit_status, rehearsed.ticks) == (True, 0, 50)


def test_one_tick_is_reported_in_the_singular(search: Recording) -> None:
    first = replace(search, ticks=search.ticks[:1])
    assert "the same in all of 1 tick\n" in words(evaluate(first))
    assert "1 of 1 tick differs\n" in words(evaluate(first, f"{APPS}:Ending"))


def words(rehearsed: Evaluation) -> str:
    console = Console(width=200)
    with console.capture() as capture:
        console.print(format_replay(rehearsed))
    return "\n".join(line.strip() for line in capture.get().splitlines())


def test_app_that_raises_has_its_own_exit_status(search: Recording) -> None:
    rehearsed = evaluate(search, f"{APPS}:Ending", {"deed": "divide"})
    assert (rehearsed.result.outcome, rehearsed.exit_status) == (Outcome.ERROR, 5)


def test_app_that_needs_what_was_not_recorded_is_refused_by_name(raises: Raises) -> None:
    reflex = recorded("avoid-obstacles", seed=1, settings={"duration_s": 1})
    with raises(UnmetNeedError, "not-recorded", devices=["eye"]):
        evaluate(reflex, "green-search")


def test_wheels_that_went_as_another_app_drove_them_end_no_rehearsal() -> None:
    ahead = recorded(f"{APPS}:Ending", settings={"deed": "go_on", "speed": 0.2}, seed=3, timeout_s=4.0)
    assert max(max(tick.sent) for tick in ahead.ticks if tick.sent) > 0
    rehearsed = evaluate(ahead, settings={"speed": -0.3})
    assert rehearsed.result.outcome is not Outcome.STOPPED, rehearsed.result.reason
    assert (rehearsed.ticks, rehearsed.exit_status) == (len(ahead.ticks), 0)


def test_sample_that_nobody_read_again_ends_no_rehearsal_however_old_it_is() -> None:
    looked = recorded("green-search", seed=7, timeout_s=4.0)
    ticks = [replace(tick, reads=() if tick.number else tick.reads) for tick in looked.ticks]
    rehearsed = evaluate(replace(looked, ticks=ticks))
    assert rehearsed.result.outcome is not Outcome.STOPPED, rehearsed.result.reason
    assert rehearsed.ticks == len(looked.ticks)
    assert rehearsed.late_reads["eye"] == len(looked.ticks) - 1
    assert rehearsed.exit_status == 0


def test_what_was_read_late_is_counted() -> None:
    seldom = recorded(f"{APPS}:Seldom", seed=5, timeout_s=2.0)
    rehearsed = evaluate(seldom, f"{APPS}:Seldom")
    assert rehearsed.late_reads == {}
    often = evaluate(seldom, f"{APPS}:Ending", {"ticks": 1000})
    assert often.exit_status == 3
    assert "nose: the recording has no sample of it by" in often.result.reason


def test_lossy_pictures_are_let_pass_with_a_warning(search: Recording) -> None:
    rehearsed = evaluate(replace(search, why_not="eye: JPEG is not what the app saw"))
    assert rehearsed.warning.startswith("eye: JPEG")
    assert rehearsed.exit_status == 0
