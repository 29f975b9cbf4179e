"""Each kind of difference between a replay and its recording is found in its tick."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from robotcore.geometry import Wheels
from robotcore.recording import DriveCommand, Read, Recording
from robotcore.recording.replay import Deviation, replay
from tests.robotcore.recording.replay.memory import change_tick, record_run
from tests.robotcore.recording.replay.test_verification import APPS, record_final_action

AT = 2
ASK = DriveCommand(Wheels(1.0, 2.0), Wheels(1.0, 2.0))


def change_settings(recording: Recording, **settings: Any) -> Recording:
    request = recording.metadata.request
    changed = replace(request, settings={**request.settings, **settings})
    return replace(recording, metadata=replace(recording.metadata, request=changed))


def find_deviation(recording: Recording) -> Deviation:
    replayed = replay(recording)
    assert replayed.exit_status == 1
    assert replayed.deviation
    assert replayed.ticks == replayed.deviation.tick
    return replayed.deviation


@pytest.mark.parametrize("app", ["FinalActionApp", "SwallowingApp"])
@pytest.mark.parametrize(
    "changes, subject, recorded, replayed",
    [
        ({"state": "elsewhere"}, "the state", "'elsewhere'", "'tick 3'"),
        ({"asks": (ASK,)}, "the command", "left 1.0, right 2.0 rad/s", "left "),
        ({"asks": (DriveCommand(),)}, "the command", "stop", "left "),
        ({"asks": ()}, "the command", "no command", "left "),
        ({"reads": ()}, "the reading of nose", "not read in this tick", "read"),
    ],
)
def test_first_difference_is_reported_with_both_values(
    app: str, changes: dict[str, Any], subject: str, recorded: str, replayed: str
) -> None:
    recording = record_run(f"{APPS}:{app}", seed=3)
    deviation = find_deviation(change_tick(recording, AT, **changes))
    assert (deviation.tick, deviation.time) == (AT, recording.ticks[AT].time)
    assert (deviation.subject, deviation.recorded) == (subject, recorded)
    assert deviation.replayed.startswith(replayed)
    assert "reads" in changes or any(read.startswith("nose ") and " m at " in read for read in deviation.reads)


def test_command_that_the_replay_does_not_give_is_a_difference() -> None:
    recording = record_final_action()
    deviation = find_deviation(change_tick(recording, AT, asks=(*recording.ticks[AT].asks, ASK)))
    assert (deviation.recorded, deviation.replayed) == ("left 1.0, right 2.0 rad/s", "no command")


def test_other_end_is_a_difference() -> None:
    recording = record_final_action()
    later = replay(replace(recording, ticks=recording.ticks[:AT])).deviation
    assert later
    assert (later.recorded, later.replayed) == ("success", "the app goes on")
    earlier = find_deviation(change_settings(recording, ticks=AT))
    assert (earlier.recorded, earlier.replayed) == ("the app goes on", "success")


def test_new_or_missing_error_of_the_app_is_a_difference() -> None:
    new = find_deviation(change_settings(record_final_action(), action="divide", ticks=AT))
    assert new.subject == "the end"
    assert "FinalActionApp raised ZeroDivisionError: in tick 2" in new.replayed
    missing = find_deviation(change_settings(record_final_action("divide"), action="succeed"))
    assert "ZeroDivisionError" in missing.recorded


def test_reading_a_device_more_or_less_often_is_no_difference() -> None:
    recording = record_final_action()
    first, *_ = (read for read in recording.ticks[AT].reads if read.device == "nose" and not read.by)
    for reads in ((first,), (first,) * 5, (first, Read("eye", 0, 0.0, 0))):
        assert replay(change_tick(recording, AT, reads=reads)).exit_status == 0


def test_command_gets_the_recorded_answer_of_the_filter() -> None:
    recording = record_run(f"{APPS}:FinalActionApp", seed=3)
    (ask,) = recording.ticks[AT].asks
    deviation = find_deviation(change_tick(recording, AT, asks=(replace(ask, given=Wheels(0.25, 0.5)),)))
    assert (deviation.subject, deviation.replayed) == ("the state", "'tick 3 held back'")
