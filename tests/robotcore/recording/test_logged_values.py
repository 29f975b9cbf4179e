"""The values that an app logs, in a recording."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from mcap.reader import make_reader

from robotcore.hal.value_log import LoggedValue
from robotcore.recording import Recording, read, reader
from robotcore.recording.codec import read_fields
from robotcore.recording.csv_table import write_csv
from robotcore.recording.logged_values import parse_logged
from robotcore.recording.recorder import Recorder
from robotcore.recording.replay import replay
from robotcore.recording.summary import summarise_contents, summarise_recorded_log
from robotcore.runtime.session import RunRequest, run
from robotcore.runtime.trace import TickRecord
from tests.robotcore.recording import logging_app
from tests.robotcore.recording.conftest import record
from tests.robotcore.recording.mcap_builder import change_messages
from tests.robotcore.recording.test_codec import get_bits
from tests.robotcore.runs import Watcher

APP = str(Path(logging_app.__file__))


class LogWatcher(Watcher):
    """Collects the logged values of each tick."""

    def __init__(self) -> None:
        super().__init__()
        self.logged: dict[int, dict[str, LoggedValue]] = {}

    def tick(self, record: TickRecord) -> None:
        self.logged[record.tick] = dict(record.logged)


@pytest.fixture(scope="module")
def logged_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("logged") / "run.mcap", app=APP).file


@pytest.fixture(scope="module")
def logged(logged_file: Path) -> Recording:
    return read(logged_file)


def test_observer_and_recording_have_the_same_logged_values(file: Path) -> None:
    recorder, watcher = Recorder(file), LogWatcher()
    run(RunRequest(APP), [recorder, watcher], [recorder.layer])
    recording = read(file)
    assert list(watcher.logged) == [tick.number for tick in recording.ticks]
    assert _list_bits(recording.logged) == _list_bits(watcher.logged)
    assert recording.logged[3]["phase"] == LoggedValue("=nan\n\x1b[2J")


def _list_bits(logged: Mapping[int, Mapping[str, LoggedValue]]) -> list[tuple[object, ...]]:
    return [
        (tick, name, type(value), get_bits(value), unit)
        for tick, values in logged.items()
        for name, (value, unit) in values.items()
    ]


def test_each_name_has_a_channel_with_a_number_that_plots_and_its_unit(logged_file: Path) -> None:
    with logged_file.open("rb") as stream:
        found = [
            (schema.name if schema else "", channel, json.loads(message.data), message.log_time)
            for schema, channel, message in make_reader(stream).iter_messages(topics=["/log/distance"])
        ]
    assert len(found) == 10
    name, channel, message, log_time = found[-1]
    assert (name, channel.message_encoding) == ("robotcore.LoggedNumber", "json")
    assert channel.metadata == {"logged": "distance", "unit": "m"}
    assert message == {"tick": 9, "value": pytest.approx(0.4, abs=0.3), "unit": "m"}
    assert log_time == 450_000_000


def test_digest_and_channels_of_a_run_that_does_not_log_are_the_same(file: Path, logged: Recording) -> None:
    recorder = Recorder(file)
    silent = run(RunRequest(APP, seed=3, settings={"is_logging": False}), [recorder], [recorder.layer])
    assert logged.result
    assert silent.trace_sha256 == logged.result.trace_sha256
    assert read(file).logged == {}
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary
    assert not [each.topic for each in summary.channels.values() if each.topic.startswith("/log/")]


def test_prints_of_the_app_are_log_lines(logged_file: Path) -> None:
    with logged_file.open("rb") as stream:
        messages = [
            (message.log_time, {number: bytes(content) for number, content in read_fields(message.data)})
            for _, _, message in make_reader(stream).iter_messages(topics=["/log"])
        ]
    level, text, source = 2, 3, 4  # the numbers of the fields in Log.proto
    printed = [(time, fields[text].decode(), fields[level]) for time, fields in messages if fields[source] == b"app"]
    assert printed[2:4] == [(50_000_000, "tick 2", b"\2"), (50_000_000, "at 0.4 m\\udc80", b"\2")]
    assert len(printed) == 20


def test_the_reader_has_the_prints_of_each_tick_and_no_line_of_the_framework(logged: Recording) -> None:
    assert [*logged.printed] == [tick.number for tick in logged.ticks]
    assert logged.printed[1] == ["tick 2", "at 0.4 m\\udc80"]


def test_replay_does_not_compare_logged_values(logged: Recording) -> None:
    changed = {tick: {**values, "distance": LoggedValue(9.0, "m")} for tick, values in logged.logged.items()}
    assert replay(replace(logged, logged=changed), app=APP).is_equal


def test_summary_has_the_unit_the_count_the_range_and_the_last_value(logged: Recording) -> None:
    series = {each.name: each for each in summarise_recorded_log(logged)}
    assert list(series) == ["distance", "error", "count", "is_even", "phase"]
    assert (series["count"].least, series["count"].greatest, series["count"].last) == (1, 10, 10)
    assert series["error"].format_cells() == ["10", "-inf rad/s²", "0.333333 rad/s²", "-inf rad/s²"]
    assert series["is_even"].format_cells() == ["10", "", "", "True"]
    assert series["phase"].count == 1


def test_summary_as_json_has_only_finite_numbers(logged: Recording) -> None:
    found = json.loads(json.dumps(summarise_contents(logged), allow_nan=False))["logged"]
    assert found[1] == {
        "name": "error",
        "unit": "rad/s²",
        "ticks": 10,
        "least": "-inf",
        "greatest": pytest.approx(1 / 3),
        "last": "-inf",
    }


def test_table_has_a_column_with_the_unit_for_each_name(logged: Recording, tmp_path: Path) -> None:
    with write_csv(logged, tmp_path, "run").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["logged_count"] for row in rows] == [str(number) for number in range(1, 11)]
    assert float(rows[0]["logged_distance_m"]) == logged.logged[0]["distance"].value
    assert [math.isnan(float(row["logged_error_rad_s2"])) for row in rows[:3]] == [False, False, True]
    assert rows[3]["logged_phase"] == "'=nan\n\x1b[2J"  # the apostrophe prevents a formula
    assert rows[4]["logged_phase"] == ""


@pytest.mark.parametrize(
    "name, schema, content",
    [
        ("a b", "robotcore.LoggedNumber", b'{"tick":1,"value":1,"unit":""}'),
        ("a", "robotcore.Tick", b'{"tick":1,"value":1,"unit":""}'),
        ("a", "robotcore.LoggedNumber", b'{"tick":1,"value":"x","unit":""}'),
        ("a", "robotcore.LoggedNumber", b'{"tick":1,"value":1,"unit":"\\n"}'),
        ("a", "robotcore.LoggedBoolean", b'{"tick":1,"value":"x","unit":""}'),
        ("a", "robotcore.LoggedText", b'{"tick":1,"value":"' + b"x" * 201 + b'","unit":""}'),
        ("a", "robotcore.LoggedText", b'{"tick":1,"value":"\\ud800","unit":""}'),
        ("a", "robotcore.LoggedText", b'{"value":"x"}'),
    ],
)
def test_value_that_no_app_can_have_logged_is_damage(name: str, schema: str, content: bytes) -> None:
    with pytest.raises(ValueError):  # noqa: PT011  the reader reports any of them as damage
        parse_logged(name, schema, content)


def test_damaged_value_ends_the_recording_before_its_chunk(logged_file: Path, file: Path) -> None:
    file.write_bytes(change_messages(logged_file, "/log/count", lambda _, content: content.replace(b"7", b"[")))
    assert read(file).is_damaged


def test_number_of_names_in_a_file_is_limited(logged_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "MAX_NAMES", 5)
    assert not read(logged_file).is_damaged
    monkeypatch.setattr(reader, "MAX_NAMES", 4)
    assert "4 names" in read(logged_file).damage
