"""A sweep's end on a terminal: a table of what was reached, and the runs that somebody should look at."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from rich import box
from rich.console import Group as Lines
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from robotcore.sweep.record import Record
from robotcore.sweep.statistics import Group

LONGEST = 20
"""So many failing runs are told one by one; a file has them all."""

_COLUMNS = ("backend", "world", "verified", "%", "95 %", "contacts", "median", "slowest")
"""Short, so that the table fits into 80 letters; the fifth is the interval."""


def summary(groups: Sequence[Group], failing: Sequence[Record], file: Path) -> RenderableType:
    """Return the table, then the failing runs with their reasons and commands; ``file`` has every one of them."""
    return Lines(_table(groups), *_failures(failing, file))


def _table(groups: Sequence[Group]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold", padding=(0, 0, 0, 1))
    for index, column in enumerate(_COLUMNS):
        table.add_column(column, style="cyan" if index < 2 else "", justify="left" if index < 2 else "right")
    for group in groups:
        table.add_row(*_row(group))
    return table


def _row(group: Group) -> tuple[str, ...]:
    return (
        group.backend,
        group.world,
        *_verified(group),
        contacts_told(group),
        time_told(group.median_time_s),
        time_told(group.slowest_time_s),
    )


def contacts_told(group: Group) -> str:
    """Return the contacts that were counted; ``≥`` says that some runs did not tell."""
    if group.contacts is None:
        return "?"
    return f"≥ {group.contacts}" if group.untold else f"{group.contacts}"


def time_told(time_s: float | None) -> str:
    """Return a group's time, or that not so many of its runs ever pass."""
    return "never" if time_s is None else f"{time_s:.1f} s"


def _verified(group: Group) -> tuple[str, str, str]:
    if not group.is_judged:
        return f"?/{group.runs}", "", ""
    low, high = group.share_95
    return f"{group.confirmed}/{group.runs}", f"{100 * group.share:.1f}", f"{100 * low:.1f}–{100 * high:.1f}"


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


def fault(record: Record) -> str:
    """Return in words why a run is failing."""
    result = record.result
    words = [result.outcome.value]
    if result.reason:
        words.append(result.reason)
    elif result.verified is False:
        words.append("the simulator does not agree")
    if result.contacts:
        words.append(f"{result.contacts} contact{'' if result.contacts == 1 else 's'}")
    return ", ".join(words)
