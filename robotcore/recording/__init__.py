"""Runs on file: a layer and an observer that record, and what is read back."""

from robotcore.recording.events import Ask, Glimpse, Raised, Read, Recorded, SampleKey, Tick, Turned
from robotcore.recording.recording import Metadata, Recording

__all__ = [
    "Ask",
    "Glimpse",
    "Metadata",
    "Raised",
    "Read",
    "Recorded",
    "Recording",
    "SampleKey",
    "Tick",
    "Turned",
]
