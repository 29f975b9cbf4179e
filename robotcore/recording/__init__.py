"""Runs on file: a layer and an observer that record, and what is read back."""

from __future__ import annotations

from pathlib import Path

from robotcore.recording.events import (
    DriveCommand,
    GroundTruthSample,
    MotorCommand,
    Read,
    RecordedError,
    RecordedSample,
    SampleKey,
    ShownPicture,
    Tick,
    WheelAngles,
)
from robotcore.recording.mcap_file import require_extra
from robotcore.recording.recording import Metadata, Recording

__all__ = [
    "DriveCommand",
    "GroundTruthSample",
    "Metadata",
    "MotorCommand",
    "Read",
    "RecordedError",
    "RecordedSample",
    "Recording",
    "SampleKey",
    "ShownPicture",
    "Tick",
    "WheelAngles",
    "read",
]


def read(path: Path) -> Recording:
    """Return what was recorded in a file: all, or what came before it was cut or damaged.

    Raises BackendMissingError where the extra is not installed, and RecordingError where there is no recording.
    """
    require_extra()
    from robotcore.recording.reader import read_file

    return read_file(path)
