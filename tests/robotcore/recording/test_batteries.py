"""Batteries in recordings, replays and comparisons."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import pytest

from robotcore.errors import DeviceError
from robotcore.kinds.battery import Voltage
from robotcore.recording import Recording, read
from robotcore.recording.csv_table import write_csv
from robotcore.recording.event_log import Level, LogLine, RunLog
from robotcore.recording.recorder import Recorder
from robotcore.recording.replay import replay
from robotcore.recording.replay.evaluation import evaluate
from robotcore.recording.summary import build_result, summarise_devices
from robotcore.runtime import sensor_monitor
from robotcore.runtime.session import RunRequest, run
from robotcore.testing.mock.devices import Script
from tests.doubles import battery_backend


def compute_voltage(time: float) -> float:
    return 7.0 - time / 7


def record_run(monkeypatch: pytest.MonkeyPatch, file: Path, volts: Script = compute_voltage) -> Recording:
    battery_backend.install(monkeypatch, volts)
    rover = str(battery_backend.load_battery_rover(file.parent).file)
    recorder = Recorder(file)
    request = RunRequest("avoid-obstacles", "powered", rover, "open", settings={"duration_s": 5.0})
    run(request, [recorder], [recorder.layer])
    assert recorder.failure is None
    return read(file)


def test_voltages_are_in_the_samples_and_the_table(monkeypatch: pytest.MonkeyPatch, file: Path) -> None:
    recording = record_run(monkeypatch, file)
    voltages = [sample for key, sample in recording.samples.items() if key.device == "cells"]
    assert voltages == [Voltage(compute_voltage(time), time, 20 * time) for time in range(6)]
    (cells,) = (each for each in summarise_devices(recording) if each.name == "cells")
    assert (cells.kind, cells.samples, cells.rate_hz) == ("battery", 6, 1.0)
    rows = list(csv.DictReader(write_csv(recording, file.with_suffix(".csv"), "").read_text().splitlines()))
    cells_of_rows = [(row["cells_v"], row["cells_time_s"]) for row in rows if row["cells_v"]]
    assert cells_of_rows == [(str(compute_voltage(time)), str(float(time))) for time in range(6)]


def test_warning_is_in_its_tick_and_in_the_log_and_a_cut_file_has_the_voltages(
    monkeypatch: pytest.MonkeyPatch, file: Path
) -> None:
    recording = record_run(monkeypatch, file, 6.0)
    first, *others = (tick.warnings for tick in recording.ticks)
    assert (first[0].partition(" V")[0], set(others)) == ("cells: 6.00", {()})
    assert LogLine(Level.Warning, *first) in list(RunLog(()).list_new(recording.ticks[0]))
    whole, cut = recording.result, build_result(replace(recording, result=None))
    assert whole
    assert cut.batteries == whole.batteries == {"cells": {"lowest_v": 6.0, "last_v": 6.0}}
    assert cut.notes == whole.notes


@pytest.mark.parametrize("period", [1.0, 0.3])
@pytest.mark.parametrize(
    "volts", [compute_voltage, lambda time: DeviceError("cells", "no answer") if time < 2.5 else 7.0]
)
def test_run_with_a_battery_is_replayed_bit_equal_at_any_pace_of_its_reads(
    monkeypatch: pytest.MonkeyPatch, file: Path, volts: Script, period: float
) -> None:
    recording = record_run(monkeypatch, file, volts)
    monkeypatch.setattr(sensor_monitor, "PERIOD_S", period)
    replayed = replay(recording)
    assert recording.result
    assert (replayed.deviation, replayed.is_exact) == (None, True)
    assert replayed.trace_sha256 == recording.result.trace_sha256
    assert period < 1 or replayed.result.batteries == recording.result.batteries
    assert not evaluate(recording).late_reads
