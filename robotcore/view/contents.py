"""What a recording holds, in a few lines and a table."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from robotcore.recording import Recording
from robotcore.recording.contents import devices_of, duration_of, interventions_of, rate_of
from robotcore.recording.ended import result_of, why_no_end
from robotcore.text import counted, escape
from robotcore.view.summary import events, heading, summary

_UNITS = ("bytes", "kB", "MB", "GB")


def contents(recording: Recording, file: Path) -> RenderableType:
    """Return the summary of a recording. Its texts are data: each stays in its line."""
    title = Text(escape(file.name), "bold") + Text(f"  {escape(', '.join(_state(recording, file)))}")
    about = [Text(f"  {escape(line)}") for line in _about(recording)]
    return Group(title, *about, Text(), _ending(recording), Text(), _devices(recording))


def _state(recording: Recording, file: Path) -> Iterator[str]:
    yield _size(file.stat().st_size)
    yield _wholeness(recording)
    yield "replayable" if recording.is_replayable else f"not replayable: {recording.why_not}"


def _wholeness(recording: Recording) -> str:
    if recording.is_damaged:
        return "damaged"
    return "cut" if recording.is_cut else "whole"


def _about(recording: Recording) -> Iterator[str]:
    about, result = recording.metadata, result_of(recording)
    yield f"{heading(result)}, robot {result.robot}, begun {about.started}"
    if settings := about.request.settings:
        yield "set: " + ", ".join(f"{name}={value}" for name, value in settings.items())
    rate = rate_of(recording)
    pace = f" at {rate:.2f} Hz" if rate else ""
    ticks, overruns = counted(len(recording.ticks), "tick"), counted(result.overruns, "overrun")
    yield f"{ticks}{pace} in {duration_of(recording):.2f} s, {overruns}"
    if result.dropped_pictures:
        yield f"dropped: {counted(result.dropped_pictures, 'picture')}"
    if causes := interventions_of(recording):
        yield "interventions: " + ", ".join(f"{cause} {count}" for cause, count in causes.items())
    yield from (f"note: {note}" for note in result.notes)
    yield "on " + ", ".join(f"{name} {value}" for name, value in about.platform.items())


def _ending(recording: Recording) -> RenderableType:
    if recording.result:
        return summary(recording.result)
    cut = Text(_wholeness(recording), "bold red" if recording.is_cut else "bold")
    cut += Text(f"  {escape(why_no_end(recording))}")
    return Text("\n").join([cut, *(Text(f"  {escape(line)}") for line in events(result_of(recording)))])


def _devices(recording: Recording) -> Table:
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold")
    for title in ("device", "kind", "samples", "a second", "reads", "errors"):
        is_name = title in ("device", "kind")
        table.add_column(title, style="cyan" if title == "device" else "", justify="left" if is_name else "right")
    for each in devices_of(recording):
        rate = "" if each.rate_hz is None else f"{each.rate_hz:.2f}"
        counts = (str(each.samples), rate, str(each.reads), str(each.errors))
        is_sensor = each.kind != "motor"
        table.add_row(each.name, each.kind.replace("_", " "), *(counts if is_sensor else [""] * 4))
    return table


def _size(count: float) -> str:
    for unit in _UNITS[:-1]:
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} {_UNITS[-1]}"
