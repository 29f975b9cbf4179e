"""Terminal output of a sweep: a progress bar, a table of the groups, and the failing runs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Hashable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
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

_LEFT_ALIGNED = ("backend", "world")
_SUMMARY_COLUMNS = (*_LEFT_ALIGNED, "verified", "%", "95 %", "contacts", "median", "slowest")
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
    return Lines(
        _render_table(groups), *_render_judge(request, groups, has_verify=has_verify), *_render_failures(failing, file)
    )


def _render_table(groups: Sequence[Group]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold", padding=(0, 0, 0, 1))
    for name in _SUMMARY_COLUMNS:
        table.add_column(
            name, style="cyan" if name in _LEFT_ALIGNED else "", justify="left" if name in _LEFT_ALIGNED else "right"
        )
    for group in groups:
        table.add_row(*(COLUMNS[name](group) for name in _SUMMARY_COLUMNS))
    return table


def _render_judge(request: RunRequest, groups: Sequence[Group], *, has_verify: bool) -> Iterator[Text]:
    """Yield the line about the judge. An installed app that judges itself needs none."""
    if not has_verify:
        yield Text(f"\n{NO_VERIFY}")
    elif request.judge or is_app_file(request.app_reference):
        yield Text(f"\nJudge: {escape(format_judge(request.judge, groups))}")


def _render_failures(failing: Sequence[Record], file: Path) -> Iterator[Text]:
    if not failing:
        return
    yield Text(f"\n{len(failing)} failing run{'' if len(failing) == 1 else 's'}:", "bold")
    causes = _group_by(format_failure, failing)
    for cause, records in sorted(causes.items(), key=lambda item: -len(item[1]))[:MAX_CAUSES]:
        yield from _render_cause(cause, records)
    if len(causes) > MAX_CAUSES:
        yield Text(f"  and {len(causes) - MAX_CAUSES} other causes")
    if len(failing) > 1:
        yield Text(f"  all failing runs: {escape(str(file))}")


def _render_cause(cause: str, records: Sequence[Record]) -> Iterator[Text]:
    words = escape(cause)
    yield Text(f"  {len(records)} × {words}" if len(records) > 1 else f"  {words}", "yellow")
    if len(records) > 1:
        for key, group in _group_by(GroupKey.of, records).items():
            yield Text(f"    {key}: {_format_seeds(group)}")
    yield Text(f"    {escape(records[0].command)}")


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


class SweepProgress:
    """A progress bar on stderr. ``with`` shows it if stderr is a terminal."""

    def __init__(self, total: int, done: int, failing: int) -> None:
        self._failing = failing
        self._bar = Progress(
            BarColumn(bar_width=None),
            MofNCompleteColumn(),
            TextColumn("{task.fields[failing]} failing"),
            TimeRemainingColumn(),
            console=Console(stderr=True, highlight=False),
            transient=True,
            speed_estimate_period=_SPEED_PERIOD_S,
            disable=not (sys.stderr and sys.stderr.isatty()),
        )
        self._task = self._bar.add_task("", total=total, completed=done, failing=failing)

    def __enter__(self) -> SweepProgress:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._bar.stop()

    def show(self, record: Record) -> None:
        """Advance the bar by a finished run."""
        self._failing += record.is_failure
        self._bar.update(self._task, advance=1, failing=self._failing)
