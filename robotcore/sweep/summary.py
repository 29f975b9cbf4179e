"""A sweep's end on a terminal: a table of what was reached, and the runs that somebody should look at."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from rich import box
from rich.console import Group as Lines
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from robotcore.appfile import is_app_file
from robotcore.plan import RunRequest
from robotcore.sweep.record import Record
from robotcore.sweep.statistics import Group
from robotcore.sweep.words import COLUMNS, fault, judge_told

LONGEST = 20
"""So many failing runs are told one by one; a file has them all."""

_TEXTS = ("backend", "world")
_SHOWN = (*_TEXTS, "verified", "%", "95 %", "contacts", "median", "slowest")
"""As many as fit into 80 letters."""


def summary(request: RunRequest, groups: Sequence[Group], failing: Sequence[Record], file: Path) -> RenderableType:
    """Return the table, then the failing runs with their reasons and commands; ``file`` has every one of them."""
    return Lines(_table(groups), *_judge(request, groups), *_failures(failing, file))


def _table(groups: Sequence[Group]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold", padding=(0, 0, 0, 1))
    for name in _SHOWN:
        table.add_column(name, style="cyan" if name in _TEXTS else "", justify="left" if name in _TEXTS else "right")
    for group in groups:
        table.add_row(*(COLUMNS[name](group) for name in _SHOWN))
    return table


def _judge(request: RunRequest, groups: Sequence[Group]) -> Iterator[Text]:
    """Yield whose word it is, where it may be another's than that of an app that is installed."""
    if request.judge or is_app_file(request.app):
        yield Text(f"\nJudge: {judge_told(request.judge, groups)}")


def _failures(failing: Sequence[Record], file: Path) -> Iterator[Text]:
    if not failing:
        return
    yield Text(f"\n{len(failing)} failing run{'' if len(failing) == 1 else 's'}:", "bold")
    ordered = sorted(failing, key=lambda record: (record.result.backend, record.result.world, record.result.seed))
    for record in ordered[:LONGEST]:
        yield Text(f"  {fault(record)}", "yellow")
        yield Text(f"    {record.command}")
    if len(failing) > LONGEST:
        yield Text(f"  and {len(failing) - LONGEST} more: {file}")
