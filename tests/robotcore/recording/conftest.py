from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from robotcore.errors import DeviceError
from robotcore.geometry import Pose
from robotcore.hal.devices import Camera, SampleT, Sensor
from robotcore.recording import Recording, read
from robotcore.recording.recorder import Recorder
from robotcore.recording.tap import RecordingTap, TickEvents
from robotcore.runtime.layers.base import Reader, Tap
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Run, RunRequest, run
from robotcore.runtime.trace import TickRecord
from tests.robotcore.recording import irregular_app

IRREGULAR_APP = str(Path(irregular_app.__file__))


class MemoryRecorder:
    """An observer that keeps the events of a run in memory, to compare them with the file."""

    def __init__(self) -> None:
        self.layer = RecordingTap(lambda: True)
        self.ticks: list[tuple[TickRecord, TickEvents]] = []
        self.poses: list[Pose] = []
        self.result: RunResult | None = None

    def begin(self, run: Run) -> None:
        self.run = run

    def tick(self, record: TickRecord) -> None:
        self.ticks.append((record, self.layer.take()))
        self.poses.append(self.run.robot.drive._odometry.latest)

    def end(self, result: RunResult) -> None:
        self.result = result


class FailingCameraTap(Tap):
    """A tap that makes every fourth read of the camera fail."""

    reads = 0

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        if not isinstance(sensor, Camera):
            return read

        def read_or_fail() -> SampleT:
            self.reads += 1
            if self.reads % 4 == 0:
                raise DeviceError(sensor.name, "no picture came")
            return read()

        return read_or_fail


class RecordedRun:
    """A run that was recorded in a file and in memory."""

    def __init__(self, file: Path, witness: MemoryRecorder, recorder: Recorder) -> None:
        self.file, self.witness, self.recorder = file, witness, recorder

    @property
    def recording(self) -> Recording:
        return read(self.file)


def record(file: Path, *below: Tap, is_jpeg: bool = False, app: str = IRREGULAR_APP, **asked: Any) -> RecordedRun:
    """Record a run of `IrregularApp`, or of another app."""
    recorder, witness = Recorder(file, is_jpeg=is_jpeg), MemoryRecorder()
    run(RunRequest(app, **{"seed": 3, **asked}), [recorder, witness], [*below, recorder.layer, witness.layer])
    return RecordedRun(file, witness, recorder)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> RecordedRun:
    """Return a successful run whose camera sometimes fails."""
    file = tmp_path_factory.mktemp("recorded") / "run.mcap"
    return record(file, FailingCameraTap(), settings={"ticks": 30})


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.mcap"
