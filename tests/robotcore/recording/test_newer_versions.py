"""Recordings of newer versions of robotcore: one that this version can read, and others that it refuses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from robotcore.compatibility import read_version
from robotcore.errors import RecordingError
from robotcore.recording import read
from tests.robotcore.recording.conftest import RecordedRun
from tests.robotcore.recording.mcap_builder import change_json
from tests.texts import CheckText, Raises

Change = Callable[[dict[str, Any]], dict[str, Any]]


def change_metadata(source: Path, target: Path, *changes: Change) -> None:
    """Write a recording whose metadata are changed."""

    def change_all(_: int, metadata: dict[str, Any]) -> dict[str, Any]:
        for change in changes:
            metadata = change(metadata)
        return metadata

    target.write_bytes(change_json(source, "/run", change_all))


def set_newer_version(metadata: dict[str, Any]) -> dict[str, Any]:
    return metadata | {"platform": metadata["platform"] | {"robotcore": "1000.0"}}


def set_next_format(metadata: dict[str, Any]) -> dict[str, Any]:
    return metadata | {"format": 2}


def add_key(metadata: dict[str, Any]) -> dict[str, Any]:
    return metadata | {"weather": "sunny"}


def add_robot_key(metadata: dict[str, Any]) -> dict[str, Any]:
    return metadata | {"description": metadata["description"] | {"wheels": 5}}


def add_device_of_a_new_kind(metadata: dict[str, Any]) -> dict[str, Any]:
    description = metadata["description"]
    devices = [*description["devices"], {"kind": "teleporter", "name": "teleporter"}]
    return metadata | {"description": description | {"devices": devices}}


@pytest.mark.parametrize("change", [set_newer_version, add_key])
def test_a_newer_recording_that_this_version_understands_is_read(
    recorded: RecordedRun, file: Path, change: Change
) -> None:
    change_metadata(recorded.file, file, change, set_newer_version)
    assert read(file).ticks == recorded.recording.ticks


@pytest.mark.parametrize("change", [set_next_format, add_robot_key, add_device_of_a_new_kind])
def test_another_newer_recording_is_refused_with_its_version(
    recorded: RecordedRun, file: Path, change: Change, raises: Raises
) -> None:
    change_metadata(recorded.file, file, change, set_newer_version)
    with raises(RecordingError, "recording-format", hide=[read_version()]):
        read(file)


def test_an_unknown_format_without_a_version_is_refused(recorded: RecordedRun, file: Path, raises: Raises) -> None:
    change_metadata(recorded.file, file, set_next_format, lambda metadata: metadata | {"platform": ["?"]})
    with raises(RecordingError, "recording-format", hide=[read_version()]):
        read(file)


def test_the_damage_of_a_newer_recording_has_its_version(
    recorded: RecordedRun, file: Path, check_text: CheckText
) -> None:
    change_metadata(recorded.file, file, set_newer_version)
    newer = file.with_name("newer.mcap")
    newer.write_bytes(change_json(file, "/ticks", lambda number, tick: tick | ({"turned": 1} if number == 5 else {})))
    recording = read(newer)
    assert recording.is_damaged
    check_text(recording.damage.partition(",")[2])
