"""Write a recording as a CSV table with one row per tick."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from robotcore.files import replace_file
from robotcore.recording.events import NUMBERS, Read
from robotcore.recording.mcap_file import build_unwritable_error
from robotcore.recording.recording import Recording
from robotcore.text import escape_formula

_NO_WHEELS, _NO_POSE = ("",) * 2, ("",) * 3
_POSE = ("x_m", "y_m", "heading_rad")
_PICTURE = "sequence"
_UNITS = {"range_sensor": "m", "encoder": "rad", "battery": "v"}


def write_csv(recording: Recording, where: Path, name: str) -> Path:
    """Write the table, and return its file. Raises RecordingError if the file cannot be written.

    An apostrophe precedes each text that a spreadsheet would run as a formula.

    where: the file, or the folder of the file.
    name: the name of the file in a folder, without ``.csv``.
    """
    file = where / f"{name}.csv" if where.is_dir() else where
    try:
        with (
            replace_file(file) as part,
            part.open("w", newline="", encoding="utf-8", errors="backslashreplace") as stream,
        ):
            writer = csv.writer(stream)
            writer.writerow(_build_header(recording))
            writer.writerows(_build_rows(recording))
    except OSError as error:
        raise build_unwritable_error(file, error) from error
    return file


def _build_header(recording: Recording) -> list[str]:
    wheels = [f"{command}_{side}_rad_s" for command in ("asked", "sent") for side in ("left", "right")]
    true = [f"true_{name}" for name in _POSE] if recording.truth else []
    devices = [column for name, unit in _list_sensors(recording) for column in (f"{name}_{unit}", f"{name}_time_s")]
    return ["tick", "time_s", "state", *wheels, *_POSE, *true, *devices, "interventions", "error"]


def _build_rows(recording: Recording) -> Iterator[list[Any]]:
    truth, sensors = {sample.tick: sample.pose for sample in recording.truth}, list(_list_sensors(recording))
    for tick in recording.ticks:
        true = list(truth.get(tick.number) or _NO_POSE) if truth else []
        decided = [*(tick.asked or _NO_WHEELS), *(tick.sent or _NO_WHEELS), *(tick.pose or _NO_POSE)]
        reads = {read.device: read for read in tick.reads if not read.error}  # the last one of each device
        samples = [cell for name, unit in sensors for cell in _build_sample_cells(recording, reads.get(name), unit)]
        causes = " ".join(each.cause for each in tick.interventions)
        state, causes, error = map(escape_formula, (tick.state, causes, tick.error.message if tick.error else ""))
        yield [tick.number, tick.time, state, *decided, *true, *samples, causes, error]


def _list_sensors(recording: Recording) -> Iterator[tuple[str, str]]:
    for device in recording.metadata.description.devices:
        if device.name in recording.metadata.devices and device.kind in (*_UNITS, "camera"):
            yield device.name, _UNITS.get(device.kind, _PICTURE)


def _build_sample_cells(recording: Recording, read: Read | None, unit: str) -> tuple[Any, Any]:
    if read is None:
        return "", ""
    sample = None if read.key is None or unit == _PICTURE else recording.samples.get(read.key)
    field, _ = NUMBERS.get(type(sample), ("", ""))
    return getattr(sample, field) if field else read.sequence, read.time
