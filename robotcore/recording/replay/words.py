"""How a replay came out, in a few lines."""

from __future__ import annotations

from collections.abc import Iterator

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from robotcore.recording.ended import result_of
from robotcore.recording.replay.rehearsal import Rehearsed
from robotcore.recording.replay.verdict import Replayed
from robotcore.runtime.apps import app_path
from robotcore.runtime.outcome import RunResult
from robotcore.text import counted, escape
from robotcore.view.summary import heading, rehearsed_heading

_GOOD, _FAIR, _BAD = "bold green", "bold yellow", "bold red"


def told(came_out: Replayed | Rehearsed) -> RenderableType:
    """Return what came out of a replay."""
    return _replayed(came_out) if isinstance(came_out, Replayed) else _rehearsed(came_out)


def _replayed(replayed: Replayed) -> RenderableType:
    verdict, style = _verdict(replayed)
    lines = [Text(verdict, style) + Text(f"  {escape(heading(result_of(replayed.recording)))}")]
    return Text("\n").join([*lines, *(Text(f"  {escape(line)}") for line in _findings(replayed))])


def _verdict(replayed: Replayed) -> tuple[str, str]:
    if not replayed.is_equal:
        return "differs", _BAD
    if replayed.is_exact:
        return "bit-equal", _GOOD
    return f"equal within {replayed.largest_difference:.1g} rad/s", _FAIR


def _findings(replayed: Replayed) -> Iterator[str]:
    if deviation := replayed.deviation:
        yield from deviation.lines()
        yield _equal_ticks(replayed)
    else:
        yield f"{counted(replayed.ticks, 'tick')}, {replayed.recording.ticks[-1].time:.2f} s"
        yield from _digest(replayed)
        if replayed.ended_by:
            yield f"the recording ends here: {replayed.ended_by}"
    yield from _app_file(replayed)
    if replayed.platform:
        yield f"recorded elsewhere: {'; '.join(replayed.platform)}"


def _equal_ticks(replayed: Replayed) -> str:
    recorded = len(replayed.recording.ticks)
    if replayed.ticks == recorded:
        return f"all that was decided in {counted(recorded, 'tick')} is equal"
    return f"before it, {replayed.ticks} of {counted(recorded, 'tick')} {'is' if recorded == 1 else 'are'} equal"


def _app_file(replayed: Replayed) -> Iterator[str]:
    """Yield whether the app's own file is the recorded one, where that may matter."""
    name = app_path(replayed.result.app).name
    if replayed.has_app_changed:
        yield f"{name} has changed since it was recorded"
    elif replayed.deviation and replayed.has_app_changed is False and not replayed.platform:
        yield f"{name} is the file that was recorded: does it use random numbers, the time, or another file?"


def _digest(replayed: Replayed) -> Iterator[str]:
    digest, recorded = replayed.trace_sha256, replayed.recorded_sha256
    if not replayed.is_equal:
        yield f"trace {digest}, but the file says {recorded}: it was changed after it was recorded"
    elif recorded == digest:
        yield f"trace {digest}, as recorded"
    else:
        yield f"trace {digest}"


def _rehearsed(rehearsed: Rehearsed) -> RenderableType:
    recorded, other = result_of(rehearsed.recording), rehearsed.result
    title = Text(escape(rehearsed_heading(other, recorded)), "bold")
    parts = [Text(f"  {escape(line)}") for line in _differences(rehearsed)]
    return Group(title, *parts, Text(), _table(rehearsed, recorded))


def _differences(rehearsed: Rehearsed) -> Iterator[str]:
    if rehearsed.warning:
        yield f"the samples are not all that the run had: {rehearsed.warning}"
    if parting := rehearsed.parting:
        yield f"they part in tick {parting.tick}, at {parting.time:g} s: {parting.what}"
        yield f"  recorded: {parting.recorded}"
        yield f"  {_name(rehearsed)}: {parting.rehearsed}"
        verb = "differs" if rehearsed.differing == 1 else "differ"
        yield f"{rehearsed.differing} of {counted(rehearsed.ticks, 'tick')} {verb}"
    else:
        yield f"the same in all of {counted(rehearsed.ticks, 'tick')}"
    for device, count in rehearsed.late_reads.items():
        yield f"{device}: in {counted(count, 'tick')} nobody had read it; the newest sample from before was given"


def _table(rehearsed: Rehearsed, recorded: RunResult) -> Table:
    other = rehearsed.result
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold")
    for title in ("", "recorded", escape(_name(rehearsed))):
        table.add_column(title, style="" if title else "cyan")
    for name in dict.fromkeys((*recorded.milestones, *other.milestones)):
        table.add_row(escape(name), _at(recorded, name), _at(other, name))
    ended = "goes on where the recording ends" if rehearsed.is_at_end else other.outcome.value
    table.add_row("outcome", recorded.outcome.value, ended)
    table.add_row("time", f"{recorded.sim_time_s:.2f} s", f"{other.sim_time_s:.2f} s")
    return table


def _name(rehearsed: Rehearsed) -> str:
    """Return what to call the other app beside the recorded one."""
    app = rehearsed.result.app
    return "now" if app == result_of(rehearsed.recording).app else app


def _at(result: RunResult, milestone: str) -> str:
    return f"{result.milestones[milestone]:.2f} s" if milestone in result.milestones else "–"
