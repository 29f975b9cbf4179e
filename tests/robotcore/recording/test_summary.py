"""Contents, table and film of a recording."""

from __future__ import annotations

import csv
from dataclasses import replace
from functools import partial
from pathlib import Path

import cv2
import pytest

from robotcore.errors import RecordingError, UnknownNameError
from robotcore.recording import Read, RecordedError, Recording
from robotcore.recording.csv_table import write_csv
from robotcore.recording.events import ActuatorCommand, MotorCommand
from robotcore.recording.summary import summarise_contents, summarise_devices
from robotcore.view.video import write_video
from tests.robotcore.recording.replay.memory import change_tick, record_run
from tests.texts import Raises


@pytest.fixture(scope="module")
def search() -> Recording:
    return record_run("green-search", seed=7, timeout_s=2.0)


def test_devices_are_counted_with_samples_reads_and_errors(search: Recording) -> None:
    failed = Read("nose", error=RecordedError("DeviceError", "nose: gone"))
    again = tuple(read for read in search.ticks[6].reads if read.device == "eye")
    changed = change_tick(change_tick(search, 5, reads=(failed,)), 7, reads=(*search.ticks[7].reads, *again))
    devices = {each.name: each for each in summarise_devices(changed)}
    nose, eye, screen, motor = (devices[name] for name in ("nose", "eye", "screen", "left_motor"))
    assert (nose.samples, nose.reads, nose.errors) == (40, 40, 1)
    assert (eye.samples, eye.reads) == (40, 41)
    assert eye.rate_hz == pytest.approx(39 / 2.0)
    assert screen.samples == 41
    assert (motor.samples, motor.rate_hz) == (0, None)


def test_commands_to_an_actuator_are_counted(search: Recording) -> None:
    failed = ActuatorCommand("screen", 0.7, error=RecordedError("DeviceError", "screen: gone"))
    changed = change_tick(search, 7, motor_asks=(MotorCommand("left_motor", 5.0, 4.0),), commands=(failed,))
    counts = {each.name: (each.commands, each.errors) for each in summarise_devices(changed)}
    assert (counts["left_motor"], counts["screen"], counts["nose"]) == ((1, 0), (41, 1), (0, 0))


def test_cut_recording_has_no_outcome(search: Recording) -> None:
    summary = summarise_contents(replace(search, result=None, is_cut=True, missing_inputs="2 sample(s) are missing"))
    assert (summary["whole"], summary["outcome"], summary["replayable"]) == (False, None, False)
    assert summary["why_not"] == "2 sample(s) are missing"
    assert summary["intervention_s"] == summarise_contents(search)["intervention_s"]
    assert summary["intervention_s"]["acceleration limit"] > 0
    empty = summarise_contents(replace(search, ticks=[], result=None, is_cut=True))
    assert (empty["ticks"], empty["rate_hz"], empty["duration_s"]) == (0, None, 0.0)


def test_table_has_one_row_per_tick_with_every_digit(search: Recording, tmp_path: Path) -> None:
    bare = change_tick(search, 9, reads=(), asked=None, sent=None, pose=None)
    file = write_csv(bare, tmp_path, "run")
    assert file == tmp_path / "run.csv"
    with file.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(search.ticks)
    tick, row = search.ticks[7], rows[7]
    assert tick.asked
    assert (int(row["tick"]), float(row["time_s"]), row["state"]) == (7, tick.time, tick.state)
    assert (float(row["asked_left_rad_s"]), float(row["asked_right_rad_s"])) == tick.asked
    assert float(row["true_x_m"]) == search.truth[7].pose.x
    nose = next(read for read in tick.reads if read.device == "nose")
    assert nose.key
    assert float(row["nose_m"]) == search.samples[nose.key].distance  # type: ignore[attr-defined]  # it is a Range
    assert (float(row["nose_time_s"]), row["eye_sequence"]) == (nose.time, "7")
    assert {rows[9][name] for name in ("nose_m", "eye_sequence", "asked_left_rad_s", "sent_left_rad_s", "x_m")} == {""}


def test_table_has_the_last_command_of_each_tick_to_an_actuator(search: Recording, tmp_path: Path) -> None:
    commands = (ActuatorCommand("screen", 0.7, 0.5), ActuatorCommand("screen", [-1.0, 0.5], "=A1"))
    changed = change_tick(search, 7, motor_asks=(MotorCommand("left_motor", 5.0, 4.0),), commands=commands)
    with write_csv(changed, tmp_path, "run").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    names = ("left_motor_asked", "left_motor_sent", "screen_asked", "screen_sent")
    assert [rows[7][name] for name in names] == ["5.0", "4.0", "-1.0 0.5", "'=A1"]
    assert {rows[6][name] for name in names} == {""}


@pytest.mark.parametrize("pace, device", [(1, None), (2, "eye")])
def test_film_lasts_as_long_as_the_run(search: Recording, tmp_path: Path, pace: int, device: str | None) -> None:
    late = replace(search, ticks=[replace(tick, time=pace * tick.time) for tick in search.ticks])
    write_video(late, tmp_path / "run.mp4", device)
    film = cv2.VideoCapture(str(tmp_path / "run.mp4"))
    assert film.get(cv2.CAP_PROP_FPS) == pytest.approx(20)
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == pace * (len(search.ticks) - 1) + 1
    film.release()


def test_output_that_cannot_be_written_is_refused(raises: Raises, search: Recording, tmp_path: Path) -> None:
    for write, name in ((write_video, "run.mp4"), (partial(write_csv, name=""), "run.csv")):
        with raises(RecordingError, "file-not-writable"):
            write(search, tmp_path / "none" / name)


@pytest.mark.parametrize("device", ["nose", "nobody"])
def test_device_without_pictures_makes_no_film(raises: Raises, search: Recording, tmp_path: Path, device: str) -> None:
    with raises(UnknownNameError, "unknown-camera-or-display-of-the-recording", name=device):
        write_video(search, tmp_path / "run.mp4", device)
