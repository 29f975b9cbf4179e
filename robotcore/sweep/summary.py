"""Terminal output of a sweep: a progress bar, a table of the groups, and the failing runs."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from rich import box
from rich.console import Console, RenderableType
from rich.console import Group as Lines
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from robotcore.runtime.apps import is_app_file
from robotcore.runtime.plan import RunRequest
from robotcore.sweep.record import GroupKey, Record, format_failure
from robotcore.sweep.statistics import Group
from robotcore.sweep.tables import COLUMNS, format_judge
from robotcore.text import escape

KeyT = TypeVar("KeyT", bound=Hashable)

NO_VERIFY = "Judge: none. The app has no verify(self, truth). Add it, or name a --judge."
"""The line about the judge if neither the app nor a judge can verify a run."""

MAX_CAUSES = 20
"""The maximum number of causes of failure in the summary. ``failures.csv`` has all of them."""

MAX_LISTED_SEEDS = 8
"""The maximum number of seeds that the summary lists for one cause on one backend in one world."""

_SUMMARY_COLUMNS = ("backend", "world", "verified", "%", "95 %", "contacts", "median", "slowest")
"""The titles of the columns in the terminal, which fit into 80 characters."""

_SPEED_PERIOD_S = 600.0
"""The seconds of recent progress from which the remaining time is estimated. They must include slow and quick runs."""


def render_summary(
    request: RunRequest, groups: Sequence[Group], failing: Sequence[Record], file: Path, *, has_verify: bool
) -> RenderableType:
    """Return the table of the groups, the line about the judge, and the failing runs by their causes.

    request: the request of the sweep.
    groups: the counts and times of the runs. Each group becomes a row.
    failing: the failing runs.
    file: the file that lists all failing runs. The summary names it.
    has_verify: whether the app or the judge has a method ``verify``.
    """
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold", padding=(0, 0, 0, 1))
    for index, name in enumerate(_SUMMARY_COLUMNS):
        table.add_column(name, style="cyan" if index < 2 else "", justify="left" if index < 2 else "right")
    for group in groups:
        table.add_row(*(COLUMNS[name](group) for name in _SUMMARY_COLUMNS))
    judge = f"Judge: {escape(format_judge(request.judge, groups))}" if has_verify else NO_VERIFY
    # An installed app that judges itself needs no line about the judge.
    needs_judge = not has_verify or request.judge or is_app_file(request.app_reference)
    return Lines(table, *([Text(f"\n{judge}")] if needs_judge else ()), *_render_failures(failing, file))


def _render_failures(failing: Sequence[Record], file: Path) -> Iterator[Text]:
    if not failing:
        return
    yield Text(f"\n{len(failing)} failing run{'' if len(failing) == 1 else 's'}:", "bold")
    causes = _group_by(_format_cause, failing)
    for records in sorted(causes.values(), key=len, reverse=True)[:MAX_CAUSES]:
        cause = format_failure(records[0])
        yield Text(f"  {len(records)} × {escape(cause)}" if len(records) > 1 else f"  {escape(cause)}", "yellow")
        if len(records) > 1:
            for key, group in _group_by(GroupKey.from_record, records).items():
                yield Text(f"    {key}: {_format_seeds(group)}")
        yield Text(f"    {escape(records[0].command)}")
    if len(causes) > MAX_CAUSES:
        yield Text(f"  and {len(causes) - MAX_CAUSES} other causes")
    if len(failing) > 1:
        yield Text(f"  all failing runs: {escape(str(file))}")


def _format_cause(record: Record) -> str:
    """Return why a run counts as failing, without measured values and numbers of contacts, which vary between runs."""
    return re.sub(r"-?\d+(\.\d+|(?=°)| contacts?$)", "…", format_failure(record))


def _format_seeds(records: Sequence[Record]) -> str:
    listed = ", ".join(str(record.result.seed) for record in records[:MAX_LISTED_SEEDS])
    more = f" and {len(records) - MAX_LISTED_SEEDS} more" if len(records) > MAX_LISTED_SEEDS else ""
    return f"seed{'' if len(records) == 1 else 's'} {listed}{more}"


def _group_by(key: Callable[[Record], KeyT], records: Sequence[Record]) -> dict[KeyT, list[Record]]:
    ordered = sorted(records, key=lambda record: (record.result.backend, record.result.world, record.result.seed))
    found: dict[KeyT, list[Record]] = {}
    for record in ordered:
        found.setdefault(key(record), []).append(record)
    return found


@contextmanager
def show_progress(total: int, done: int, failing: int) -> Iterator[Callable[[Record], None]]:
    """Show a progress bar on stderr if it is a terminal, and yield a function that advances the bar by a record.

    total: the number of all runs.
    done: the number of runs that were finished before.
    failing: the number of runs among them that failed.
    """
    bar = Progress(
        BarColumn(bar_width=None),
        MofNCompleteColumn(),
        TextColumn("{task.fields[failing]} failing"),
        TimeRemainingColumn(),
        console=Console(stderr=True, highlight=False),
        transient=True,
        speed_estimate_period=_SPEED_PERIOD_S,
        disable=not (sys.stderr and sys.stderr.isatty()),
    )
    task = bar.add_task("", total=total, completed=done, failing=failing)

    def advance(record: Record) -> None:
        nonlocal failing
        failing += record.is_failure
        bar.update(task, advance=1, failing=failing)

    with bar:
        yield advance
