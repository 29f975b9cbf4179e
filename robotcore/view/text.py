"""Format the result of a run, the contents of a recording and the result of a replay for a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import inf
from pathlib import Path

from rich import box
from rich.console import Group, RenderableType
from rich.filesize import decimal
from rich.table import Table
from rich.text import Text

from robotcore.errors import RobotcoreError
from robotcore.recording import Recording
from robotcore.recording.logged_summary import LoggedSeries
from robotcore.recording.replay.evaluation import Evaluation
from robotcore.recording.replay.verification import ReplayResult
from robotcore.recording.summary import (
    build_result,
    count_interventions,
    explain_missing_end,
    measure_duration,
    measure_rate,
    summarise_devices,
    summarise_recorded_log,
)
from robotcore.runtime.apps import app_path
from robotcore.runtime.faults.spec import Spec
from robotcore.runtime.result import Outcome, RunResult
from robotcore.safety.velocity_limits import AccelerationLimit, VelocityLimit
from robotcore.text import escape, pluralize

_STYLES = {Outcome.SUCCESS: "bold green", Outcome.INTERRUPTED: "bold yellow", Outcome.TIMEOUT: "bold yellow"}
_RED = "bold red"


def format_summary(result: RunResult) -> Text:
    """Return a text with the headline, the measurements, the milestones and the reason, each in its own line."""
    style = _RED if result.dispute else _STYLES.get(result.outcome, _RED)
    lines = [", ".join(list_measures(result)), *list_events(result)]
    if result.reason and not isinstance(result.error, RobotcoreError):
        lines.append(result.reason)
    return _join_lines(Text(result.headline, style), format_heading(result), lines)


def _join_lines(verdict: Text, heading: str, lines: Iterable[str]) -> Text:
    """Return a text with a verdict, a heading beside it, and indented lines below them."""
    first = verdict + Text(f"  {escape(heading)}")
    return Text("\n").join([first, *(Text(f"  {escape(line)}") for line in lines)])


def format_heading(result: RunResult) -> str:
    """Return a heading such as ``green-search on kinematic, arena, seed 7``."""
    place = [result.world] if result.world else []
    seed = [f"seed {result.seed}"] if result.seed is not None else []
    ideal = ["ideal devices"] if result.ideal else []
    return ", ".join([f"{result.app} on {result.backend}", *place, *seed, *ideal])


def format_evaluation_heading(result: RunResult, recorded: RunResult) -> str:
    """Return a heading such as ``avoid-obstacles on the samples of green-search on kinematic, arena``."""
    return f"{result.app} on the samples of {format_heading(recorded)}"


def list_measures(result: RunResult) -> Iterator[str]:
    """Yield each measurement of a run as text."""
    if result.outcome is Outcome.SUCCESS and result.verified is not None:
        yield result.dispute or f"verified by the {result.verifier}"
    pace = result.sim_time_s / max(result.wall_time_s, 1e-3)
    yield f"{result.sim_time_s:.1f} s at {pace:.{0 if pace >= 10 else 1}f}x real time"
    if result.distance_to_target_m is not None:
        yield f"{result.distance_to_target_m:.2f} m from the target"
    if result.contacts == 0:  # the headline has the other numbers
        yield pluralize(result.contacts, "contact")
    if result.overruns:
        yield pluralize(result.overruns, "overrun")
    for name, battery in result.batteries.items():
        yield f"{name} at {battery['last_v']:.2f} V, lowest {battery['lowest_v']:.2f} V"


def list_events(result: RunResult) -> Iterator[str]:
    """Yield a line with the milestones, one with the interventions, and the lines of `list_faults`, if they exist."""
    if result.milestones:
        yield ", ".join(f"{name} at {time:.1f} s" for name, time in result.milestones.items())
    if causes := list(list_interventions(result.intervention_s, result.sim_time_s)):
        yield ", ".join(causes)
    yield from list_faults(result)


_NAMED_S = 0.5
"""The shortest duration of interventions that a text names, in seconds."""

_UNNAMED = {VelocityLimit.cause, AccelerationLimit.cause}
"""The causes that a text does not name, because they occur in nearly every run."""


_UNITS_SHARE = 0.5
"""The share of a run for which the velocity limit must hold until a text names it. The app may use other units."""


def list_interventions(intervention_s: Mapping[str, float], sim_time_s: float = inf) -> Iterator[str]:
    """Yield a text such as ``the range guard held it back for 15.0 s`` for each cause of interventions.

    The acceleration limit, and each cause of less than 0.5 s have no text. The velocity limit has one only if it held
    for most of the run.

    intervention_s: the duration of each cause of interventions, in seconds.
    sim_time_s: the duration of the run, in seconds.
    """
    for cause, seconds in intervention_s.items():
        if seconds >= _NAMED_S and cause not in _UNNAMED:
            yield f"the {cause} held it back for {seconds:.1f} s"
        elif cause == VelocityLimit.cause and seconds >= max(_NAMED_S, _UNITS_SHARE * sim_time_s):
            yield f"the {cause} held it back for {seconds:.1f} s (velocities are in m/s and rad/s, not in degrees)"


def list_faults(result: RunResult) -> Iterator[str]:
    """Yield a line with the injected faults that began, and one with those that would have begun later."""
    for title, has_begun in (("with faults", True), ("the run ended before", False)):
        if texts := [text for text in result.faults if (Spec.parse(text).after_s <= result.sim_time_s) is has_begun]:
            yield f"{title}: {'; '.join(texts)}"


def format_contents(recording: Recording, file: Path) -> RenderableType:
    """Return the summary of a recording for a terminal. Control characters in its texts are escaped."""
    states = ", ".join(_list_states(recording, file))
    about = _join_lines(Text(escape(file.name), "bold"), states, _list_facts(recording))
    parts = [about, Text(), _format_ending(recording), Text(), _build_device_table(recording)]
    if logged := summarise_recorded_log(recording):
        parts += [Text(), _build_logged_table(logged)]
    return Group(*parts)


def _list_states(recording: Recording, file: Path) -> Iterator[str]:
    yield decimal(file.stat().st_size, precision=2)
    yield _format_wholeness(recording)
    yield "replayable" if recording.is_replayable else f"not replayable: {recording.missing_inputs}"


def _format_wholeness(recording: Recording) -> str:
    if recording.is_damaged:
        return "damaged"
    return "cut" if recording.is_cut else "whole"


def _list_facts(recording: Recording) -> Iterator[str]:
    about, result = recording.metadata, build_result(recording)
    yield f"{format_heading(result)}, robot {result.robot}, begun {about.started}"
    if settings := about.request.settings:
        yield "set: " + ", ".join(f"{name}={value}" for name, value in settings.items())
    rate = measure_rate(recording)
    pace = f" at {rate:.2f} Hz" if rate else ""
    ticks, overruns = pluralize(len(recording.ticks), "tick"), pluralize(result.overruns, "overrun")
    yield f"{ticks}{pace} in {measure_duration(recording):.2f} s, {overruns}"
    if result.dropped_pictures:
        yield f"dropped: {pluralize(result.dropped_pictures, 'picture')}"
    if causes := count_interventions(recording):
        yield "interventions: " + ", ".join(f"{cause} {count}" for cause, count in causes.items())
    yield from (f"note: {note}" for note in result.notes)
    yield "on " + ", ".join(f"{name} {value}" for name, value in about.platform.items())


def _format_ending(recording: Recording) -> RenderableType:
    if recording.result:
        return format_summary(recording.result)
    cut = Text(_format_wholeness(recording), "bold red" if recording.is_cut else "bold")
    return _join_lines(cut, explain_missing_end(recording), list_events(build_result(recording)))


def build_table() -> Table:
    """Return an empty table in the style of all tables of recordings."""
    return Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold")


def _build_device_table(recording: Recording) -> Table:
    table = build_table()
    for title in ("device", "kind", "samples", "per second", "reads", "commands", "errors"):
        is_name = title in ("device", "kind")
        table.add_column(title, style="cyan" if title == "device" else "", justify="left" if is_name else "right")
    for each in summarise_devices(recording):
        rate = "" if each.rate_hz is None else f"{each.rate_hz:.2f}"
        counts = (str(each.samples), rate, str(each.reads), str(each.commands), str(each.errors))
        is_counted = each.kind != "motor" or each.commands or each.errors
        table.add_row(each.name, each.kind.replace("_", " "), *(counts if is_counted else [""] * 5))
    return table


def _build_logged_table(logged: Iterable[LoggedSeries]) -> Table:
    """Return a table of the values that an app logged."""
    table = build_table()
    for title in ("logged", "ticks", "least", "greatest", "last"):
        is_name = title == "logged"
        table.add_column(title, style="cyan" if is_name else "", justify="left" if is_name else "right")
    for series in logged:
        table.add_row(series.name, *map(escape, series.format_cells()))
    return table


def format_replay(replay: ReplayResult | Evaluation) -> RenderableType:
    """Return the result of a replay or an evaluation for a terminal, with the values that its app logged."""
    text = _format_result(replay) if isinstance(replay, ReplayResult) else _format_evaluation(replay)
    return Group(text, Text(), _build_logged_table(replay.logged)) if replay.logged else text


def _format_result(replayed: ReplayResult) -> RenderableType:
    verdict, style = f"equal within {replayed.largest_difference:.1g} rad/s", "bold yellow"
    if not replayed.is_equal:
        verdict, style = "differs", _RED
    elif replayed.is_exact:
        verdict, style = "bit-equal", "bold green"
    return _join_lines(Text(verdict, style), format_heading(build_result(replayed.recording)), list_findings(replayed))


def list_findings(replayed: ReplayResult) -> Iterator[str]:
    """Yield what a verification of a recording found, as lines of text."""
    ticks, count = replayed.recording.ticks, pluralize(len(replayed.recording.ticks), "tick")
    digest, recorded = replayed.trace_sha256, replayed.recorded_sha256
    if deviation := replayed.deviation:
        yield from deviation.lines
        if replayed.ticks == len(ticks):
            yield f"the decisions of all {count} are equal"
        else:
            yield f"the decisions before this deviation are equal: {replayed.ticks} of {count}"
    else:
        yield f"{pluralize(replayed.ticks, 'tick')}, {ticks[-1].time:.2f} s"
        if replayed.is_equal:
            yield f"trace {digest}" + (", as recorded" if recorded == digest else "")
        else:
            yield f"trace {digest}, but the recording says {recorded}: the recording was changed after the run"
        if replayed.ended_by:
            yield f"the recording ends here: {replayed.ended_by}"
    yield from _list_app_findings(replayed)
    if replayed.platform:
        yield f"recorded on another platform: {'; '.join(replayed.platform)}"


def _list_app_findings(replayed: ReplayResult) -> Iterator[str]:
    name = app_path(replayed.result.app).name
    if replayed.has_app_changed:
        yield f"{name} has changed since it was recorded"
    elif replayed.deviation and replayed.has_app_changed is False and not replayed.platform:
        yield f"{name} has not changed since it was recorded. Does it use random numbers, the time, or another file?"


def _format_evaluation(evaluation: Evaluation) -> RenderableType:
    recorded, other = build_result(evaluation.recording), evaluation.result
    title = Text(escape(format_evaluation_heading(other, recorded)), "bold")
    parts = [Text(f"  {escape(line)}") for line in list_differences(evaluation)]
    return Group(title, *parts, Text(), _build_table(evaluation, recorded))


def list_differences(evaluation: Evaluation) -> Iterator[str]:
    """Yield how the decisions of an evaluated app differ from the recorded ones, as lines of text."""
    if evaluation.warning:
        yield f"the recording lacks samples of the run: {evaluation.warning}"
    if first := evaluation.first_difference:
        yield f"first difference in tick {first.tick}, at {first.time:g} s: {first.subject}"
        yield f"  recorded: {first.recorded}"
        yield f"  {_name_app(evaluation)}: {first.replayed}"
        verb = "differs" if evaluation.differing == 1 else "differ"
        yield f"{evaluation.differing} of {pluralize(evaluation.ticks, 'tick')} {verb}"
    else:
        yield f"the same in all of {pluralize(evaluation.ticks, 'tick')}"
    for device, count in evaluation.late_reads.items():
        ticks = pluralize(count, "tick")
        yield f"{device}: not read in {ticks} of the recorded run. The app received the previous sample"


def _build_table(evaluation: Evaluation, recorded: RunResult) -> Table:
    other = evaluation.result
    table = build_table()
    for title in ("", "recorded", escape(_name_app(evaluation))):
        table.add_column(title, style="" if title else "cyan")
    for name in dict.fromkeys((*recorded.milestones, *other.milestones)):
        table.add_row(escape(name), _format_milestone_time(recorded, name), _format_milestone_time(other, name))
    ended = "continues after the end" if evaluation.is_at_end else other.outcome.value
    table.add_row("outcome", recorded.outcome.value, ended)
    table.add_row("time", f"{recorded.sim_time_s:.2f} s", f"{other.sim_time_s:.2f} s")
    return table


def _name_app(evaluation: Evaluation) -> str:
    """Return the name of the evaluated app, or ``now`` if the recorded app was evaluated."""
    app = evaluation.result.app
    return "now" if app == build_result(evaluation.recording).app else app


def _format_milestone_time(result: RunResult, milestone: str) -> str:
    return f"{result.milestones[milestone]:.2f} s" if milestone in result.milestones else "–"
