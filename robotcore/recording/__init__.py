"""Record a run into an MCAP file, and read it back."""

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
    """Read a recording: the whole file, or the part before a cut or damage.

    Raises BackendMissingError if the extra is not installed, and RecordingError if the file is no recording.
    """
    require_extra()
    from robotcore.recording.reader import read_file

    return read_file(path)
