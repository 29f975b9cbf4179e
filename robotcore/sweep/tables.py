"""Tables of records for spreadsheets, and the columns that show a group of runs."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from robotcore.files import replace_text
from robotcore.sweep.record import Record, format_failure
from robotcore.sweep.statistics import Group
from robotcore.text import escape_formula

TABLE = "results.csv"
"""The file name of the table of all runs."""

FAILURES = "failures.csv"
"""The file name of the table of failing runs."""

_LAST_COLUMNS = ("fault", "command", "picture")


def write_tables(directory: Path, records: Callable[[], Iterable[Record]]) -> None:
    """Write ``results.csv`` with all records, and ``failures.csv`` with the failing ones, with the same columns.

    directory: the folder of the tables.
    records: a function that returns the records. It is called several times, so that it can read them from a file.
    """
    columns = list_columns(records())
    write_csv(directory / TABLE, columns, records())
    write_csv(directory / FAILURES, columns, (record for record in records() if record.is_failure))


def are_current(directory: Path, source: Path) -> bool:
    """Return whether both tables in a folder are newer than the results file ``source``."""
    tables = [directory / name for name in (TABLE, FAILURES)]
    return all(table.exists() and table.stat().st_mtime_ns > source.stat().st_mtime_ns for table in tables)


def list_columns(records: Iterable[Record]) -> list[str]:
    """Return the names of the columns of records. A field that is a mapping has a column for each of its keys."""
    columns = dict.fromkeys(column for record in records for column in _make_row(record))
    return sorted(columns, key=_LAST_COLUMNS.__contains__)


def write_csv(file: Path, columns: Sequence[str], records: Iterable[Record]) -> None:
    """Write a table with a row for each record. A lone surrogate in a text is escaped."""
    with replace_text(file, newline="", errors="backslashreplace") as table:
        writer = csv.DictWriter(table, columns)
        writer.writeheader()
        writer.writerows(map(_make_row, records))


def _make_row(record: Record) -> dict[str, Any]:
    values = {each.name: getattr(record.result, each.name) for each in fields(record.result) if each.name != "error"}
    why = format_failure(record) if record.is_failure else ""
    values |= {
        "outcome": record.result.outcome.value,
        "fault": why,
        "command": record.command,
        "picture": record.picture,
    }
    return {column: value for key, item in values.items() for column, value in _flatten(key, item)}


def _flatten(key: str, item: Any) -> Iterator[tuple[str, Any]]:
    """Yield the columns of a field, and their values. Texts are escaped, because an app may set any reason."""
    if isinstance(item, dict):
        for name, value in item.items():
            yield from _flatten(f"{key}.{name}", value)
        return
    value = "; ".join(item) if isinstance(item, list) else item
    yield key, escape_formula(value) if isinstance(value, str) else value


def format_verified(group: Group) -> str:
    """Return the number of verified runs and of all runs, such as ``97/100``; ``?/100`` if no run could be verified."""
    return f"{'?' if group.verified is None else group.verified}/{group.runs}"


def format_contacts(group: Group) -> str:
    """Return the number of contacts as text: ``2``, ``≥ 2`` if some runs did not count them, ``?`` if no run did."""
    if group.contacts is None:
        return "?"
    return f"≥ {group.contacts}" if group.contacts_unknown else f"{group.contacts}"


def format_time(time_s: float | None) -> str:
    """Return a time of a group as text; ``never`` for None, which means that too few runs pass."""
    return "never" if time_s is None else f"{time_s:.1f} s"


COLUMNS: dict[str, Callable[[Group], str]] = {
    "backend": lambda group: group.backend,
    "world": lambda group: group.world,
    "passed": lambda group: f"{group.runs - group.failing}/{group.runs}",
    "verified": format_verified,
    "%": lambda group: "" if group.verified_share is None else f"{100 * group.verified_share:.1f}",
    "95 %": lambda group: "–".join(f"{100 * edge:.1f}" for edge in group.verified_95 or ()),
    "contacts": format_contacts,
    "median": lambda group: format_time(group.median_time_s),
    "90 % within": lambda group: format_time(group.p90_time_s),
    "slowest": lambda group: format_time(group.slowest_time_s),
}
"""The columns that show a group of runs: a function for each title.

``%`` is the share of verified runs, and ``95 %`` the interval of this share. If no run could be verified, both
are empty.
"""


def format_judge(judge: str | None, groups: Iterable[Group]) -> str:
    """Return who judged the runs: the judge's name, ``the app itself``, or ``none`` if no run could be verified."""
    return judge or ("none" if all(group.verified is None for group in groups) else "the app itself")
