"""Summarise the values that an app logged, by name."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from robotcore.hal.value_log import Logged, LoggedValue
from robotcore.recording.codec import to_plain


@dataclass
class LoggedSeries:
    """The values that an app logged under a name."""

    name: str
    unit: str
    last: Logged
    """The last value."""
    count: int = 0
    """The number of ticks with a value."""
    least: float | None = None
    """The least number that is not NaN; None without such a number."""
    greatest: float | None = None
    """The greatest number that is not NaN; None without such a number."""

    def add(self, value: Logged) -> None:
        """Add the value of the next tick."""
        self.last = value
        self.count += 1
        if not isinstance(value, (bool, str)) and not math.isnan(value):
            self.least = value if self.least is None else min(self.least, value)
            self.greatest = value if self.greatest is None else max(self.greatest, value)

    def format_cells(self) -> list[str]:
        """Return the number of ticks, the least, the greatest and the last value as texts with their unit."""
        return [str(self.count), *("" if each is None else self._format(each) for each in self._values)]

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields. A number that is not finite is a text.

        The JSON keys:

        name: text; the name of the value.
        unit: text; the unit; empty if it has none.
        ticks: whole number; the number of ticks with a value.
        least: number, text or null; the least number. Null without a number, and a text if it is infinite.
        greatest: number, text or null; the greatest number.
        last: number, text, true or false; the last value.
        """
        least, greatest, last = map(to_plain, self._values)
        return {
            "name": self.name,
            "unit": self.unit,
            "ticks": self.count,
            "least": least,
            "greatest": greatest,
            "last": last,
        }

    @property
    def _values(self) -> tuple[float | None, float | None, Logged]:
        return self.least, self.greatest, self.last

    def _format(self, value: Logged) -> str:
        text = f"{value:.6g}" if isinstance(value, float) else str(value)
        return f"{text} {self.unit}".rstrip()


class LoggedSummary:
    """Summarises the values of each name, in the order of the first values."""

    def __init__(self) -> None:
        self._series: dict[str, LoggedSeries] = {}

    def add(self, values: Mapping[str, LoggedValue]) -> None:
        """Add the values of the next tick, by name."""
        for name, (value, unit) in values.items():
            self._series.setdefault(name, LoggedSeries(name, unit, value)).add(value)

    @property
    def series(self) -> list[LoggedSeries]:
        """The summary of each name."""
        return list(self._series.values())
