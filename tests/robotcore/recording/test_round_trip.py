from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robotcore.errors import DeviceError, InvalidCommandError
from robotcore.geometry import Wheels
from robotcore.kinds.camera import Frame
from robotcore.optics import Image
from robotcore.recording import RecordedError, SampleKey, read
from robotcore.recording.recorder import Recorder
from robotcore.recording.replay import replay
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import RunRequest, run
from tests.robotcore.description.courses import QUADRANTS, load_course
from tests.robotcore.recording.conftest import IRREGULAR_APP, RecordedRun, record
from tests.robotcore.recording.replay.memory import Disturbance, press_emergency_stop
from tests.robotcore.recording.test_codec import get_bits

DRIVES_BY_AN_ARRAY = """
import numpy as np
from robotcore import Behaviour, Role, Status

class DriveByAnArray(Behaviour):
    needs = frozenset({Role.DRIVE})
    def step(self, robot):
        robot.drive.set_wheels(np.where(True, 0.5, 0.0), np.where(True, 0.5, 0.0))
        return Status.RUNNING
"""


def test_recorded_ticks_poses_and_truth_are_bit_equal(recorded: RecordedRun) -> None:
    recording, witness = recorded.recording, recorded.witness
    assert len(recording.ticks) == 30
    assert get_bits(tuple(recording.ticks)) == get_bits(tuple(witness.ticks))
    assert get_bits(recording.ticks[-1].pose) == get_bits(witness.run.robot.drive._odometry.latest)
    assert get_bits(tuple(recording.truth)) == get_bits(tuple(witness.truth))
    assert recording.truth[-1].pose != recording.truth[0].pose


def test_command_that_is_an_array_element_is_recorded(tmp_path: Path) -> None:
    app = tmp_path / "where.py"
    app.write_text(DRIVES_BY_AN_ARRAY)
    recorder = Recorder(tmp_path / "run.mcap")
    run(RunRequest(str(app), timeout_s=0.2), [recorder], [recorder.layer])
    assert recorder.failure is None
    assert {tick.asked for tick in read(recorder.path).ticks} == {Wheels(0.5, 0.5)}


@pytest.mark.parametrize(
    "picture", [QUADRANTS, np.random.default_rng(1).integers(0, 256, (830, 830, 3), np.uint8)], ids=["small", "2 MB"]
)
def test_picture_on_the_floor_is_recorded_and_its_file_is_not_read_again(tmp_path: Path, picture: Image) -> None:
    world = load_course(tmp_path, picture)
    recorder = Recorder(tmp_path / "run.mcap")
    request = RunRequest("mark-green", world=str(tmp_path / "course.toml"), timeout_s=0.3)
    result = run(request, [recorder], [recorder.layer])
    for name in ("course.png", "course.toml"):
        (tmp_path / name).unlink()
    recording = read(recorder.path)
    assert recording.metadata.world == world
    assert replay(recording).trace_sha256 == result.trace_sha256


def test_recorded_samples_are_equal_and_each_read_has_one_or_an_error(recorded: RecordedRun) -> None:
    recording = recorded.recording
    kept = recorded.witness.samples
    assert set(recording.samples) == kept.keys()
    for read_of_tick in (each for tick in recording.ticks for each in tick.reads):
        assert bool(read_of_tick.error) == (read_of_tick.key is None)
        if not (key := read_of_tick.key):
            continue
        again, sample = recording.samples[key], kept[key]
        assert (again.time, again.sequence) == (read_of_tick.time, read_of_tick.sequence)
        if isinstance(sample, Frame):
            assert isinstance(again, Frame)
            assert np.array_equal(again.image, sample.image)
            assert not again.image.flags.writeable
        else:
            assert get_bits(again) == get_bits(sample)


def test_errors_and_pictures_are_recorded(recorded: RecordedRun) -> None:
    recording = recorded.recording
    failed = [read.error for tick in recording.ticks for read in tick.reads if read.error]
    error = failed[0].rebuild()
    assert isinstance(error, DeviceError)
    assert error.device == "eye"
    tick = next(tick for tick in recording.ticks if tick.shown)
    assert tick.shown[0].key
    shown = recording.samples[tick.shown[0].key]
    assert isinstance(shown, Frame)
    assert (shown.time, shown.image.ndim) == (tick.time, 2)


def test_metadata_of_the_run_is_recorded(recorded: RecordedRun) -> None:
    recorded_value, run = recorded.recording.metadata, recorded.witness.run
    assert recorded_value.request == run.request
    assert (recorded_value.description, recorded_value.world) == (run.description, run.world)
    assert recorded_value.devices == tuple(run.robot.devices)
    assert recorded_value.settings == {"end": "success", "ticks": 30}
    assert recorded_value.source == Path(IRREGULAR_APP).read_text()
    assert recorded_value.is_stepped
    assert {"python", "numpy", "machine"} <= set(recorded_value.platform)


def test_whole_recording_has_a_result_and_can_be_replayed(recorded: RecordedRun) -> None:
    recording, result = recorded.recording, recorded.witness.result
    assert result
    assert recording.result == replace(result, error=None, dropped_pictures=0)
    assert (recording.is_cut, recording.is_replayable, recording.missing_inputs) == (False, True, "")


@pytest.mark.parametrize("end", ["nan", "swallowed"])
def test_command_that_is_nan_is_recorded_with_its_error(file: Path, end: str) -> None:
    last = record(file, settings={"end": end}).recording.ticks[-1]
    assert last.error
    assert last.error.kind == "InvalidCommandError"
    ask = last.asks[-1]
    assert ask.asked
    assert not all(map(math.isfinite, ask.asked))
    assert ask.error
    assert isinstance(ask.error.rebuild(), InvalidCommandError)


def test_e_stop_is_the_error_of_the_last_tick(file: Path) -> None:
    recorder = Recorder(file)
    run(RunRequest(IRREGULAR_APP), [Disturbance(3, press_emergency_stop), recorder], [recorder.layer])
    recording = read(file)
    errors = [tick.error for tick in recording.ticks]
    assert errors == [None] * 3 + [RecordedError("EmergencyStopError", "e-stop: the button was pressed")]
    assert recording.result
    assert recording.result.outcome is Outcome.STOPPED


@pytest.mark.slow
def test_recording_changes_no_decision_and_has_no_exception_around_the_run(file: Path) -> None:
    alone = run(RunRequest(IRREGULAR_APP, seed=3))
    try:
        int("")
    except ValueError:
        recorded = record(file)
    assert [tick.error for tick in recorded.recording.ticks] == [None] * 8
    assert recorded.witness.result
    assert recorded.witness.result.trace_sha256 == alone.trace_sha256


@pytest.mark.slow
def test_jpeg_recording_is_smaller_and_cannot_be_replayed(file: Path) -> None:
    recording = record(file, is_jpeg=True).recording
    assert recording.missing_inputs == "the pictures of eye are JPEGs, which differ from those that the app read"
    frame = recording.samples[SampleKey("eye", 0)]
    assert isinstance(frame, Frame)
    assert frame.image.shape == (240, 320, 3)
