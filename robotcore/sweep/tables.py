"""Records as a table for a spreadsheet."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from robotcore.sweep.record import Record

_LAST = ("command", "picture")


def write_csv(records: Callable[[], Iterable[Record]], file: Path) -> None:
    """Write a row for each record; a mapping has a column for each of its keys. The path is left out.

    ``records`` is called twice: once for the columns, once for the rows.
    """
    columns = {column: None for record in records() for column in _cells(record)}
    ordered = [*(column for column in columns if column not in _LAST), *(c for c in _LAST if c in columns)]
    with file.open("w", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, ordered)
        writer.writeheader()
        writer.writerows(map(_cells, records()))


def _cells(record: Record) -> dict[str, Any]:
    told = json.loads(record.to_json())
    del told["path"]
    return {column: value for key, item in told.items() for column, value in _columns(key, item)}


def _columns(key: str, item: Any) -> list[tuple[str, Any]]:
    if isinstance(item, dict):
        return [(f"{key}.{name}", value) for name, value in item.items()]
    return [(key, item)]
