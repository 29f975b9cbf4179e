from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from robotcore.kinds.camera import Camera
from robotcore.recording import Recording, read
from robotcore.recording.recorder import Recorder
from robotcore.runtime.layers.base import Tap
from robotcore.runtime.session import RunRequest, run
from tests.robotcore.recording import irregular_app
from tests.robotcore.recording.replay.memory import FailingDevices, Memory

IRREGULAR_APP = str(Path(irregular_app.__file__))


@dataclass(frozen=True)
class RecordedRun:
    """A run that was recorded in a file and in memory."""

    file: Path
    witness: Memory

    @property
    def recording(self) -> Recording:
        return read(self.file)


def record(file: Path, *below: Tap, is_jpeg: bool = False, app: str = IRREGULAR_APP, **asked: Any) -> RecordedRun:
    """Record a run of `IrregularApp`, or of another app."""
    recorder, witness = Recorder(file, is_jpeg=is_jpeg), Memory()
    run(RunRequest(app, **{"seed": 3, **asked}), [recorder, witness], [*below, recorder.layer, witness.layer])
    return RecordedRun(file, witness)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> RecordedRun:
    """Return a successful run whose camera sometimes fails."""
    file = tmp_path_factory.mktemp("recorded") / "run.mcap"
    return record(file, FailingDevices(Camera, every=4), settings={"ticks": 30})


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.mcap"


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """Mount an empty disk of 6 MB. Skip the test if the user may not mount one."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=6m", "small-disk", str(folder)]
    unmount = ["umount", str(folder)]
    if os.geteuid() or subprocess.run(mount, check=False, capture_output=True).returncode:
        pytest.skip("this user cannot mount a disk")
    yield folder
    subprocess.run(unmount, check=True)
