"""Records as a table for a spreadsheet."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from robotcore.sweep.record import Record
from robotcore.sweep.replacing import replacing
from robotcore.sweep.words import fault

TABLE, FAILURES = "results.csv", "failures.csv"
"""All runs, and the failing ones alone."""

_LAST = ("fault", "command", "picture")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def write_tables(directory: Path, records: Callable[[], Iterable[Record]]) -> None:
    """Write both tables, with the same columns; ``records`` yields all of them anew each time."""
    columns = columns_of(records())
    write_csv(directory / TABLE, columns, records())
    write_csv(directory / FAILURES, columns, (record for record in records() if record.is_failure))


def are_younger(directory: Path, source: Path) -> bool:
    """Return whether both tables were written after the last change of the file that they are made of."""
    tables = [directory / name for name in (TABLE, FAILURES)]
    return all(table.exists() and _changed_ns(table) > _changed_ns(source) for table in tables)


def columns_of(records: Iterable[Record]) -> list[str]:
    """Return the columns that records need: a mapping has one for each of its keys. The path is left out."""
    columns = dict.fromkeys(column for record in records for column in _cells(record))
    return sorted(columns, key=lambda column: column in _LAST)


def write_csv(file: Path, columns: Sequence[str], records: Iterable[Record]) -> None:
    """Write a row for each record; what is no Unicode is told by its escapes."""
    with replacing(file, newline="", errors="backslashreplace") as table:
        writer = csv.DictWriter(table, columns)
        writer.writeheader()
        writer.writerows(map(_cells, records))


def _changed_ns(file: Path) -> int:
    return file.stat().st_mtime_ns


def _cells(record: Record) -> dict[str, Any]:
    result = {each.name: getattr(record.result, each.name) for each in fields(record.result) if each.name != "error"}
    why = fault(record) if record.is_failure else ""
    more = {"outcome": record.result.outcome.value, "fault": why, "command": record.command, "picture": record.picture}
    told = {**result, **more}
    return {column: _harmless(value) for key, item in told.items() for column, value in _columns(key, item)}


def _harmless(value: Any) -> Any:
    """Return a value that a spreadsheet does not take for a formula: an app's words are somebody's, and may be one.

    OWASP, CSV injection.
    """
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value


def _columns(key: str, item: Any) -> list[tuple[str, Any]]:
    if isinstance(item, dict):
        return [column for name, value in item.items() for column in _columns(f"{key}.{name}", value)]
    return [(key, "; ".join(item) if isinstance(item, list) else item)]
