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


class Witness:
    """A recorder in memory, to compare with the file."""

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


class Blinking(Tap):
    """A camera that fails at every fourth read."""

    reads = 0

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        if not isinstance(sensor, Camera):
            return read

        def blinking() -> SampleT:
            self.reads += 1
            if self.reads % 4 == 0:
                raise DeviceError(sensor.name, "no picture came")
            return read()

        return blinking


class Recorded:
    """A recorded run: the file, its recording, and the recorder in memory."""

    def __init__(self, file: Path, witness: Witness, recorder: Recorder) -> None:
        self.file, self.witness, self.recorder = file, witness, recorder

    @property
    def recording(self) -> Recording:
        return read(self.file)


def record(file: Path, *below: Tap, is_jpeg: bool = False, app: str = IRREGULAR_APP, **asked: Any) -> Recorded:
    """Record a run of `IrregularApp`, or of another app."""
    recorder, witness = Recorder(file, is_jpeg=is_jpeg), Witness()
    run(RunRequest(app, **{"seed": 3, **asked}), [recorder, witness], [*below, recorder.layer, witness.layer])
    return Recorded(file, witness, recorder)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """A successful run with a camera that fails sometimes."""
    file = tmp_path_factory.mktemp("recorded") / "run.mcap"
    return record(file, Blinking(), settings={"ticks": 30})


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.mcap"
