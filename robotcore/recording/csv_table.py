"""Write a recording as a CSV table with one row per tick."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from robotcore.files import replace_file
from robotcore.hal.device import Value, list_values
from robotcore.hal.kind import load_kind
from robotcore.hal.value_log import Logged
from robotcore.recording.events import Read
from robotcore.recording.mcap_file import build_unwritable_error
from robotcore.recording.recording import Recording
from robotcore.text import escape_formula

_NO_WHEELS, _NO_POSE, _NO_COMMAND = ("",) * 2, ("",) * 3, (None,) * 2
_POSE = ("x_m", "y_m", "heading_rad")
_PICTURE = "sequence"


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
    devices = [column for each in _list_sensors(recording) for column in (*each.columns, f"{each.name}_time_s")]
    commands = [f"{name}_{command}" for name in _list_actuators(recording) for command in ("asked", "sent")]
    logged = [f"logged_{_add_unit(name, unit)}" for name, unit in _list_logged(recording).items()]
    return ["tick", "time_s", "state", *wheels, *_POSE, *true, *devices, *commands, *logged, "interventions", "error"]


def _build_rows(recording: Recording) -> Iterator[list[Any]]:
    truth, sensors = {sample.tick: sample.pose for sample in recording.truth}, list(_list_sensors(recording))
    actuators, names = list(_list_actuators(recording)), list(_list_logged(recording))
    for tick in recording.ticks:
        true = list(truth.get(tick.number) or _NO_POSE) if truth else []
        decided = [*(tick.asked or _NO_WHEELS), *(tick.sent or _NO_WHEELS), *(tick.pose or _NO_POSE)]
        reads = {read.device: read for read in tick.reads if not read.error}  # the last one of each device
        samples = [cell for each in sensors for cell in _build_sample_cells(recording, reads.get(each.name), each)]
        last = {each.device: (each.asked, each.given) for each in tick.list_commands()}
        commands = [_format_command(each) for name in actuators for each in last.get(name, _NO_COMMAND)]
        values = recording.logged.get(tick.number, {})
        logged = [_format_logged(values[name].value) if name in values else "" for name in names]
        causes = " ".join(each.cause for each in tick.interventions)
        state, causes, error = map(escape_formula, (tick.state, causes, tick.error.message if tick.error else ""))
        yield [tick.number, tick.time, state, *decided, *true, *samples, *commands, *logged, causes, error]


class _Sensor(NamedTuple):
    name: str
    values: tuple[Value, ...]
    """The numbers of a sample; none for a sensor whose samples are pictures."""

    @property
    def columns(self) -> list[str]:
        if not self.values:
            return [f"{self.name}_{_PICTURE}"]
        fields = [f"{self.name}_{each.field}" if len(self.values) > 1 else self.name for each in self.values]
        return [_add_unit(field, each.unit) for field, each in zip(fields, self.values, strict=True)]


def _add_unit(name: str, unit: str) -> str:
    """Return the title of a column, such as ``gyro_rad_s``."""
    return f"{name}_{unit.lower().replace('/', '_').replace('²', '2')}" if unit else name


def _list_sensors(recording: Recording) -> Iterator[_Sensor]:
    for device in recording.metadata.description.devices:
        sample = load_kind(device.kind).sample
        if device.name in recording.metadata.devices and sample:
            yield _Sensor(device.name, list_values(sample))


def _list_actuators(recording: Recording) -> Iterator[str]:
    """Yield the names of the actuators that the app commanded, other than the drive and displays."""
    commanded = {each.device for tick in recording.ticks for each in tick.list_commands()}
    yield from (device.name for device in recording.metadata.description.devices if device.name in commanded)


def _list_logged(recording: Recording) -> dict[str, str]:
    """Return the unit of each logged value, by name."""
    ticks = (recording.logged.get(tick.number, {}) for tick in recording.ticks)
    return {name: logged.unit for values in ticks for name, logged in values.items()}


def _format_logged(value: Logged) -> Logged:
    return escape_formula(value) if isinstance(value, str) else value


def _build_sample_cells(recording: Recording, read: Read | None, sensor: _Sensor) -> list[Any]:
    if read is None:
        return [""] * (len(sensor.columns) + 1)
    if not sensor.values:
        return [read.sequence, read.time]
    sample = recording.samples.get(read.key) if read.key else None
    return [*(_format_cell(getattr(sample, each.field, "")) for each in sensor.values), read.time]


def _format_command(command: Any) -> Any:
    """Return a number as it is, a list of numbers with spaces between them, and any other command as a text."""
    if command is None or isinstance(command, (float, int)):
        return command
    if isinstance(command, list) and all(isinstance(each, (float, int)) for each in command):
        return _format_cell(tuple(command))
    return escape_formula(str(command))


def _format_cell(value: Any) -> Any:
    """Return a value, and the numbers of a tuple as a text with spaces between them."""
    return " ".join(map(repr, value)) if isinstance(value, tuple) else value
