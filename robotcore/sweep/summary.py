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
from robotcore.sweep.statistics import Group, wilson

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
        "?" if group.contacts is None else f"{group.contacts}",
        f"{group.median_time:.1f} s",
        f"{group.slowest_time:.1f} s",
    )


def _verified(group: Group) -> tuple[str, str, str]:
    if group.verified is None:
        return f"?/{group.runs}", "", ""
    low, high = wilson(group.verified, group.runs)
    share = 100 * group.verified / group.runs
    return f"{group.verified}/{group.runs}", f"{share:.1f}", f"{100 * low:.1f}–{100 * high:.1f}"


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
