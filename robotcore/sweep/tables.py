"""Records as a table for a spreadsheet."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from robotcore.sweep.record import Record

_LAST = ("command", "picture")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def columns_of(records: Iterable[Record]) -> list[str]:
    """Return the columns that records need: a mapping has one for each of its keys. The path is left out."""
    columns = dict.fromkeys(column for record in records for column in _cells(record))
    return sorted(columns, key=lambda column: column in _LAST)


def write_csv(file: Path, columns: Sequence[str], records: Iterable[Record]) -> None:
    """Write a row for each record; what is no Unicode is told by its escapes."""
    with file.open("w", newline="", encoding="utf-8", errors="backslashreplace") as table:
        writer = csv.DictWriter(table, columns)
        writer.writeheader()
        writer.writerows(map(_cells, records))


def _cells(record: Record) -> dict[str, Any]:
    told = {**json.loads(record.result.to_json()), "command": record.command, "picture": record.picture}
    return {column: _harmless(value) for key, item in told.items() for column, value in _columns(key, item)}


def _harmless(value: Any) -> Any:
    """Return a value that a spreadsheet does not take for a formula: an app's words are somebody's, and may be one.

    OWASP, CSV injection.
    """
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value


def _columns(key: str, item: Any) -> list[tuple[str, Any]]:
    if isinstance(item, dict):
        return [(f"{key}.{name}", value) for name, value in item.items()]
    return [(key, item)]
