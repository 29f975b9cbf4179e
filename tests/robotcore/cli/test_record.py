from __future__ import annotations

import json
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from robotcore import Outcome, RunResult
from robotcore.cli.output_files import finish_recording
from robotcore.recording import read
from robotcore.recording.recorder import Recorder
from robotcore.recording.segments import locate_segments
from tests.robotcore.cli.conftest import AppFile, Cli
from tests.texts import CheckText

DEAF = """
            from threading import Event
            while True:
                try:
                    Event().wait()
                except BaseException:
                    pass
"""
RUN = RunResult("an-app", "kinematic", "rover", "open", 1, Outcome.SUCCESS, 0)
SHORT = ("run", "avoid-obstacles", "--world", "open", "--set", "duration_s=0.5")


def test_a_run_is_recorded_and_the_file_is_named(cli: Cli, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    answer = cli(*SHORT, "--record", str(file))
    assert answer.status == 0
    assert answer.out.endswith(f"The recording: {file}\n")
    recording = read(file)
    assert recording.is_replayable
    assert recording.metadata.settings["duration_s"] == 0.5


def test_pictures_that_were_dropped_are_counted(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr("robotcore.hal.clock.SteppedClock.is_lockstep", False)
    monkeypatch.setattr("robotcore.recording.recorder.WriteQueue.has_room", lambda _: False)
    file = tmp_path / "run.mcap"
    command = ("run", "mark-green", "--robot", "lookout", "--world", "open", "--timeout", "0.3")
    answer = cli(*command, "--record", str(file), "--json")
    assert answer.json["dropped_pictures"] > 0
    check_text(answer.err, hide=[f"{answer.json['dropped_pictures']} picture"])
    assert cli("info", str(file), "--json").json["dropped_pictures"] == answer.json["dropped_pictures"]


@pytest.mark.slow
def test_the_recording_of_a_hanging_app_has_its_interventions(app_file: AppFile, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    command = [sys.executable, "-m", "robotcore", "run", app_file(DEAF), "--record", str(file), "--json"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 4
    assert ended.stderr.endswith(f"\nThe recording: {file}\n")
    in_ticks = [each.cause for tick in read(file).ticks for each in tick.interventions]
    answer = json.loads(ended.stdout)
    assert answer["interventions"] == len(in_ticks) + 1
    assert set(answer["intervention_s"]) == {*in_ticks, "watchdog"}


def test_a_recording_without_its_end_is_reported_as_cut(tmp_path: Path, check_text: CheckText) -> None:
    is_written = threading.Event()
    recorder = Recorder(tmp_path / "run.mcap")
    recorder._thread = threading.Thread(target=is_written.wait)
    recorder._thread.start()
    _, answer = finish_recording(RUN, recorder)
    check_text(answer)
    locate_segments(recorder.path).mkdir()
    _, answer = finish_recording(RUN, recorder)
    check_text(answer)
    is_written.set()
    recorder._thread.join()


def test_a_recording_at_its_limit_is_no_failure(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    file = tmp_path / "run.mcap"
    answer = cli(*SHORT, "--record", str(file), "--record-limit", "1 kB")
    assert (answer.status, answer.err) == (0, "")
    about = cli("info", str(file), "--json").json
    why = about["reason"]
    assert answer.out.endswith(f"The recording: {file}; {why}\n")
    assert (about["whole"], about["ticks"], about["outcome"]) == (True, 1, None)
    check_text(why)
    replayed = cli("replay", str(file))
    assert replayed.status == 0
    assert why in replayed.out


def test_a_flight_recorder_keeps_the_end_of_the_run(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    file = tmp_path / "run.mcap"
    command = ("run", "avoid-obstacles", "--set", "duration_s=4", "--record", str(file), "--record-last", "0.5s")
    answer = cli(*command)
    assert answer.status == 0
    first = read(file).ticks[0]
    assert 0 < first.time <= 3.5
    check_text(answer.out.splitlines()[-1].replace(str(file), "run.mcap"), hide=[f"{first.time:.1f}"])
    about = cli("info", str(file), "--json").json
    assert (about["whole"], about["replayable"], about["outcome"]) == (True, False, "success")
    replayed = cli("replay", str(file))
    assert replayed.status == 2
    assert cli("replay", str(file), "--app", "avoid-obstacles").status == 0


def test_record_jpeg_is_recorded_as_jpeg(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    file = tmp_path / "run.mcap"
    assert cli("run", "green-search", "--timeout", "0.2", "--record", str(file), "--record-jpeg").status == 1
    check_text(read(file).missing_inputs)


@pytest.mark.parametrize(
    "arguments",
    [
        ("--record", "run.bag"),
        ("--record", "gone/run.mcap"),
        ("--record", "run.mcap", "--record-limit", "0"),
        ("--record-limit", "1MB"),
        ("--record-last", "10min"),
        ("--record", "run.mcap", "--record-last", "10min", "--record-limit", "1MB"),
        *(("--record", "run.mcap", "--record-last", wrong) for wrong in ("0", "0min", "-1min", "NaN", "10 bananas")),
        ("--record", "folder", "--record-last", "10min"),
        ("--record", "folder.mcap", "--record-last", "10min"),
        ("--record", "old.mcap", "--record-last", "10min"),
        ("--record", "killed.mcap", "--record-last", "10min"),
    ],
)
def test_a_recording_that_cannot_be_written_is_refused_before_the_run(
    cli: Cli,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    check_text: CheckText,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder.mcap").mkdir()
    (tmp_path / "old.mcap").write_bytes(b"a run of yesterday")
    (tmp_path / "killed.mcap.segments").mkdir()
    answer = cli(*SHORT, *arguments)
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)


def test_the_replayed_recording_is_not_overwritten(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    file = tmp_path / "run.mcap"
    cli(*SHORT, "--record", str(file))
    before = file.read_bytes()
    replayed = ("run", "avoid-obstacles", "--backend", "replay", "--option", f"file={file}")
    answer = cli(*replayed, "--record", str(tmp_path / "." / "run.mcap"))
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)
    assert file.read_bytes() == before
    assert cli(*replayed, "--record", str(tmp_path / "again.mcap"), "--set", "duration_s=0.5").status == 0


def test_a_recording_is_overwritten_only_with_force(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    file = tmp_path / "run.mcap"
    file.write_bytes(b"a run of yesterday")
    answer = cli(*SHORT, "--record", str(file), "--json")
    assert (answer.status, answer.json["kind"]) == (2, "recording-exists")
    check_text(answer.json["error"])
    assert file.read_bytes() == b"a run of yesterday"
    forced = cli(*SHORT, "--record", str(file), "--force", "--json")
    assert (forced.status, forced.json["dropped_pictures"]) == (0, 0)
    check_text(forced.err)
    assert read(file).is_replayable
    file.write_bytes(b"")
    assert cli(*SHORT, "--record", str(file)).status == 0


def test_an_incomplete_recording_is_a_failure(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("robotcore.recording.mcap_file.write_all", full)
    answer = cli(*SHORT, "--record", str(tmp_path / "run.mcap"), "--json")
    assert answer.status == answer.json["exit_status"] == 1
    assert answer.json["outcome"] == "success"
    check_text(answer.json["reason"])
    assert answer.err.count("\n") == 1


def test_a_run_that_did_not_begin_leaves_no_recording(cli: Cli, tmp_path: Path) -> None:
    answer = cli("run", "green-search", "--robot", "nobody", "--record", str(tmp_path / "run.mcap"))
    assert answer.status == 2
    assert not (tmp_path / "run.mcap").exists()
    assert "run.mcap" not in answer.out
