"""Runs on file: a layer and an observer that record, and what is read back."""

from __future__ import annotations

from pathlib import Path

from robotcore.recording.events import Ask, Glimpse, MotorAsk, Raised, Read, Recorded, SampleKey, Shown, Tick, Turned
from robotcore.recording.mcap_file import require_extra
from robotcore.recording.recording import Metadata, Recording

__all__ = [
    "Ask",
    "Glimpse",
    "Metadata",
    "MotorAsk",
    "Raised",
    "Read",
    "Recorded",
    "Recording",
    "SampleKey",
    "Shown",
    "Tick",
    "Turned",
    "read",
]


def read(path: Path) -> Recording:
    """Return what was recorded in a file: all, or what came before it was cut or damaged.

    Raises BackendMissingError where the extra is not installed, and RecordingError where there is no recording.
    """
    require_extra()
    from robotcore.recording.reader import read_file

    return read_file(path)
