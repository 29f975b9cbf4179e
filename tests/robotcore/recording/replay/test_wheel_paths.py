"""Recordings of wheels that accelerate within ticks: their angles between two ticks are recorded and replayed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.kinematic.backend import KinematicBackend
from robotcore import RunRequest, run
from robotcore.geometry import Wheels
from robotcore.hal.drive import WheelPath
from robotcore.recording import Recording, Tick, read
from robotcore.recording.codec import from_json, to_json
from robotcore.recording.events import RecordedError, WheelAngles
from robotcore.recording.recorder import Recorder
from robotcore.recording.replay import evaluate, replay
from robotcore.recording.replay.app_run import TickReader
from robotcore.recording.validation import parse_tick
from tests.robotcore.recording.replay.memory import record_run

APP = f"{Path(__file__).parent / 'recorded_apps.py'}:BangBang"
ANGLES, BETWEEN = Wheels(1.0, 2.0), (Wheels(0.25, 0.0), Wheels(0.5, 1.5))


def count_paths(recording: Recording) -> int:
    return sum(bool(turned.between) for tick in recording.ticks for turned in tick.turned)


def list_states(recording: Recording) -> list[str]:
    return [tick.state for tick in recording.ticks]


@pytest.mark.parametrize("reads", [0, 1, 2])
@pytest.mark.parametrize("robot", ["rover", "picar"])
def test_run_with_paths_is_replayed_bit_equal(robot: str, reads: int, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap")
    request = RunRequest(APP, robot=robot, world="open", rate_hz=10, settings={"reads": reads})
    result = run(request, [recorder], [recorder.layer])
    recording = read(recorder.path)
    replayed = replay(recording)
    assert count_paths(recording) > 5
    assert replayed.is_exact
    assert replayed.is_equal, replayed.deviation
    assert replayed.trace_sha256 == result.trace_sha256
    assert recording.ticks[-1].pose is not None


def test_app_that_reads_the_pose_more_often_than_the_recorded_one_gets_the_same_pose() -> None:
    recording = record_run(APP, world="open", rate_hz=10, settings={"reads": 1})
    assert count_paths(recording) > 5
    often = evaluate(recording, APP, {"reads": 3})
    assert often.states == [" ".join([state] * 3) for state in list_states(recording)]
    assert evaluate(recording, APP, {"reads": 1}).differing == 0


def test_recording_without_paths_is_replayed_bit_equal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(KinematicBackend, "encoder_rate_hz", None)
    old = record_run(APP, world="open", rate_hz=10)
    monkeypatch.undo()
    assert not any("between" in to_json(tick).decode() for tick in old.ticks)
    again = replace(old, ticks=[from_json(Tick, to_json(tick)) for tick in old.ticks])
    replayed = replay(again)
    assert replayed.is_exact
    assert replayed.is_equal, replayed.deviation


def test_path_survives_the_file_and_an_old_tick_has_none() -> None:
    tick = Tick(0, 0.0, "", turned=(WheelAngles.from_path(WheelPath(ANGLES, BETWEEN), None),))
    (turned,) = parse_tick(to_json(tick), None).turned
    assert turned.path == WheelPath(ANGLES, BETWEEN)
    message = json.loads(to_json(tick))
    del message["turned"][0]["between"]
    (turned,) = parse_tick(json.dumps(message).encode(), None).turned
    assert turned.path == WheelPath(ANGLES)


def test_error_of_a_reading_has_no_path() -> None:
    assert WheelAngles.from_path(None, RecordedError("DeviceError", "unplugged")).path is None


@pytest.mark.parametrize("angle", [1e13, -1e13])
def test_impossible_angle_in_a_path_is_refused(angle: float) -> None:
    tick = Tick(0, 0.0, "", turned=(WheelAngles(ANGLES, between=(Wheels(0.0, 0.0), Wheels(0.0, angle))),))
    with pytest.raises(ValueError, match="above the limit"):
        parse_tick(to_json(tick), None)


def test_path_that_is_too_long_is_refused() -> None:
    tick = Tick(0, 0.0, "", turned=(WheelAngles(ANGLES, between=(ANGLES,) * 10_001),))
    with pytest.raises(ValueError, match="at most 10000"):
        parse_tick(to_json(tick), None)


def test_further_reading_in_a_recorded_tick_has_no_way() -> None:
    first = WheelAngles(Wheels(0.0, 0.0), between=BETWEEN)
    reader = TickReader(Tick(0, 0.0, "", turned=(first, WheelAngles(ANGLES, between=BETWEEN))))
    readings = [reader.next_angles() for _ in range(4)]
    assert readings == [first, WheelAngles(ANGLES, between=BETWEEN), WheelAngles(ANGLES), WheelAngles(ANGLES)]
    assert TickReader(Tick(0, 0.0, "")).next_angles() is None
