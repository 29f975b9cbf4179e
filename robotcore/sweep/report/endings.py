"""In which ways runs fail, and where: what an engineer looks at before any single run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from robotcore.sweep.record import Record
from robotcore.sweep.report.series import Series
from robotcore.sweep.words import ending, kind

MAX_ENDINGS = 12
"""More are told as one: an app may say something else each time."""


class Ending(NamedTuple):
    """A way to fail; ``counts`` has a number for each of the series."""

    told: str
    runs: int
    counts: tuple[int, ...]


def endings_of(series: Sequence[Series]) -> list[Ending]:
    """Return the ways in which runs fail, the most frequent first."""
    tallies = [Counter(_told(record) for record in each.records if record.is_failure) for each in series]
    total: Counter[str] = sum(tallies, Counter())
    common = [told for told, _ in total.most_common(MAX_ENDINGS)]
    rows = [Ending(told, total[told], tuple(tally[told] for tally in tallies)) for told in common]
    rest = tuple(sum(tally.values()) - sum(tally[told] for told in common) for tally in tallies)
    ways = len(total) - len(common)
    return [*rows, Ending(f"in {ways} other way{'s' * (ways > 1)}", sum(rest), rest)] if ways else rows


def _told(record: Record) -> str:
    """Return how a run ended; or that it touched something, where it succeeded but for that."""
    told = kind(record.result)
    return told if told == "contact" else ending(record.result)
