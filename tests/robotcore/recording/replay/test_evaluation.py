"""Evaluation of an app on a recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from robotcore.errors import DeviceError, UnmetNeedError
from robotcore.recording import Recording
from robotcore.recording.replay import evaluate
from robotcore.runtime.result import Outcome
from robotcore.view.text import format_replay
from tests.robotcore.recording.replay.memory import record_run
from tests.texts import CheckText, Raises

APPS = str(Path(__file__).parent / "recorded_apps.py")


@pytest.fixture(scope="module")
def search() -> Recording:
    return record_run("green-search", seed=7, timeout_s=8.0)


@pytest.mark.slow
def test_recorded_app_has_no_difference(search: Recording) -> None:
    evaluation = evaluate(search)
    assert (evaluation.first_difference, evaluation.differing) == (None, 0)
    assert evaluation.ticks == len(search.ticks)
    assert search.result
    assert evaluation.result.trace_sha256 == search.result.trace_sha256


@pytest.mark.slow
def test_other_setting_differs_from_its_first_effect_on(search: Recording) -> None:
    evaluation = evaluate(search, settings={"speed_m_s": "0.1"})
    first_difference = evaluation.first_difference
    assert first_difference
    assert first_difference.subject == "the command"
    assert first_difference.tick > 0
    assert 0 < evaluation.differing <= evaluation.ticks
    assert evaluation.exit_status == 0


def test_text_has_the_first_difference_and_both_ends(
    search: Recording, check_text: CheckText, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(APPS).parent)
    console = Console(width=200)
    with console.capture() as capture:
        for app in (None, "recorded_apps.py:FinalActionApp"):
            console.print(format_replay(evaluate(replace(search, ticks=search.ticks[:1]), app)))
    check_text("\n".join(line.strip() for line in capture.get().splitlines()))


def test_need_for_an_unrecorded_device_is_refused(raises: Raises) -> None:
    reflex = record_run("avoid-obstacles", seed=1, settings={"duration_s": 1})
    with raises(UnmetNeedError, "not-recorded", devices=["eye"]):
        evaluate(reflex, "green-search")


def test_late_reads_are_counted() -> None:
    seldom = record_run(f"{APPS}:IntermittentApp", seed=5, timeout_s=2.0)
    evaluation = evaluate(seldom, f"{APPS}:IntermittentApp")
    assert evaluation.late_reads == {}
    often = evaluate(seldom, f"{APPS}:FinalActionApp", {"ticks": 1000})
    assert often.exit_status == 3
    assert isinstance(often.result.error, DeviceError)
    assert often.result.error.device == "nose"


def test_app_that_raises_has_its_own_exit_status_and_the_end_of_the_recording_is_no_error(search: Recording) -> None:
    evaluation = evaluate(search, f"{APPS}:FinalActionApp", {"action": "divide"})
    assert (evaluation.result.outcome, evaluation.exit_status) == (Outcome.ERROR, 5)
    jpeg = replace(search, ticks=search.ticks[:50], missing_inputs="the pictures of eye are JPEGs")
    evaluation = evaluate(jpeg, settings={"speed_m_s": 0.1})
    assert (evaluation.is_at_end, evaluation.exit_status, evaluation.ticks) == (True, 0, 50)
    assert evaluation.warning == jpeg.missing_inputs


def test_evaluation_makes_no_check_of_wheel_tracking_or_age() -> None:
    ahead = record_run(f"{APPS}:FinalActionApp", settings={"action": "go_on", "speed": 0.2}, seed=3, timeout_s=4.0)
    unread = replace(ahead, ticks=[replace(tick, reads=() if tick.number else tick.reads) for tick in ahead.ticks])
    assert max(max(tick.sent) for tick in ahead.ticks if tick.sent) > 0
    for recording, late in ((ahead, None), (unread, len(ahead.ticks) - 1)):
        evaluation = evaluate(recording, settings={"speed": -0.3})
        assert evaluation.result.outcome is not Outcome.STOPPED, evaluation.result.reason
        assert (evaluation.ticks, evaluation.exit_status) == (len(ahead.ticks), 0)
        assert evaluation.late_reads.get("nose") == late
