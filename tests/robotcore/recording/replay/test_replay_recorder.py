"""The recordings of replays."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.geometry import Wheels
from robotcore.recording import Recording, read
from robotcore.recording.replay import Evaluation, ReplayRecorder, ReplayResult, evaluate, replay
from tests.robotcore.recording.conftest import record
from tests.robotcore.recording.test_codec import get_bits

APP = """
from robotcore import Behaviour, Role, Status

class Reflex(Behaviour):
    needs = frozenset({Role.DRIVE, Role.RANGE, Role.CAMERA})

    def step(self, robot):
        distance = robot.range.read().distance
        if robot.clock.now() < 0.35:
            robot.camera.read()
        robot.drive.set_velocity(0.2 if distance > 0.4 else 0.0, 0.0)
        return Status.RUNNING
"""
LOGGING = APP.replace("        if robot", '        robot.log("distance", distance, "m")\n        if robot')


@pytest.fixture
def app(tmp_path: Path) -> Path:
    file = tmp_path / "reflex.py"
    file.write_text(APP)
    return file


@pytest.fixture
def recording(app: Path, tmp_path: Path) -> Recording:
    return record(tmp_path / "run.mcap", app=str(app), seed=7, world="clutter", timeout_s=0.5).recording


def replay_recorded(recording: Recording, app: Path) -> tuple[ReplayResult, Recording]:
    recorder = ReplayRecorder(app.with_name("again.mcap"), recording)
    result = replay(recording, app=str(app), recorder=recorder)
    assert recorder.failure is None
    return result, read(recorder.path)


def test_value_that_was_added_to_the_app_after_the_run_is_in_the_recording_of_its_replay(
    recording: Recording, app: Path
) -> None:
    app.write_text(LOGGING)
    result, again = replay_recorded(recording, app)
    assert result.is_equal
    assert recording.logged == {}
    assert [values["distance"].unit for values in again.logged.values()] == ["m"] * 11
    assert [(each.name, each.count) for each in result.logged] == [("distance", 11)]
    assert result.to_dict()["logged"][0]["last"] == again.logged[10]["distance"].value
    assert again.metadata.source == LOGGING


def test_recording_of_a_replay_has_the_run_the_world_the_samples_and_the_true_poses(
    recording: Recording, app: Path
) -> None:
    _, again = replay_recorded(recording, app)
    first, second = recording.metadata, again.metadata
    assert (second.description, second.world, second.started) == (first.description, first.world, first.started)
    assert (second.request.backend, second.request.seed) == ("kinematic", 7)
    assert get_bits(tuple(again.truth)) == get_bits(tuple(recording.truth))
    assert [tick.pose for tick in again.ticks] == [tick.pose for tick in recording.ticks]
    assert recording.result
    assert again.result
    assert (again.result.backend, again.result.world, again.result.seed) == ("kinematic", "clutter", 7)
    assert again.result.trace_sha256 == recording.result.trace_sha256


def test_recording_of_a_replay_is_replayed_bit_equal(recording: Recording, app: Path) -> None:
    _, again = replay_recorded(recording, app)
    assert again.is_replayable
    result = replay(again, app=str(app))
    assert result.is_equal
    assert result.is_exact


def test_recording_of_a_replay_has_the_tick_that_differs(recording: Recording, app: Path) -> None:
    app.write_text(LOGGING.replace("distance > 0.4", "robot.clock.now() < 0.33"))
    result, again = replay_recorded(recording, app)
    assert result.ticks == 7
    assert again.logged[7]["distance"].unit == "m"
    assert len(again.ticks) == 8


def test_recording_of_a_replay_that_differs_in_a_reading_is_not_damaged(recording: Recording, app: Path) -> None:
    app.write_text(LOGGING.replace("robot.clock.now() < 0.35", "True"))
    result, again = replay_recorded(recording, app)
    assert result.ticks == 7
    assert not again.is_damaged
    assert len(again.ticks) == 8


def test_evaluation_is_recorded(recording: Recording, app: Path) -> None:
    app.write_text(LOGGING.replace("0.2 if", "0.1 if"))
    recorder = ReplayRecorder(app.with_name("again.mcap"), recording)
    result = evaluate(recording, str(app), recorder=recorder)
    again = read(recorder.path)
    assert isinstance(result, Evaluation)
    assert result.differing == 11
    assert result.to_dict()["logged"][0]["ticks"] == 11
    assert len(again.logged) == 11
    assert again.ticks[-1].asked != recording.ticks[-1].asked
    assert isinstance(again.ticks[-1].asked, Wheels)
