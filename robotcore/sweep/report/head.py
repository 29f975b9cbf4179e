"""The head of the page: what was run, when, and what came of it in one sentence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path

from robotcore.runtime.outcome import RunResult
from robotcore.sweep.record import Record
from robotcore.sweep.seeds import seeds_told
from robotcore.sweep.words import kind


@dataclass(frozen=True)
class Head:
    """``facts`` are pairs of a term and what it is; ``causes`` how many failing runs ended in which way.

    ``said`` are those of the passing runs that nobody could verify.
    """

    apps: str
    runs: int
    failing: int
    said: int
    causes: tuple[tuple[str, int], ...]
    facts: tuple[tuple[str, str], ...]
    asked: str

    @classmethod
    def of(cls, records: Sequence[Record], asked: str, folder: Path, judge: str = "") -> Head:
        """Return the head of a page made now; the results are in ``folder``, and ``judge`` says whose word counts."""
        results = [record.result for record in records]
        failing = [record.result for record in records if record.is_failure]
        said = sum(record.result.verified is None and not record.is_failure for record in records)
        causes = tuple(Counter(map(kind, failing)).most_common())
        facts = tuple(
            (term, told) for term, told in [("Judge", judge), *_facts(results), ("Results in", str(folder))] if told
        )
        return cls(_names(results, lambda each: each.app), len(records), len(failing), said, causes, facts, asked)


def _facts(results: Sequence[RunResult]) -> Iterable[tuple[str, str]]:
    yield "Robot", _names(results, lambda each: each.robot)
    yield "Backends", _names(results, lambda each: each.backend)
    yield "Worlds", _names(results, lambda each: each.world)
    yield "Seeds", seeds_told(sorted({each.seed for each in results if each.seed is not None}))
    yield "Robot's time", _duration(sum(each.sim_time_s for each in results))
    yield "Computing time", _duration(sum(each.wall_time_s for each in results))
    yield "robotcore", version("robotcore")
    yield "Page made", datetime.now(timezone.utc).astimezone().strftime("%Y-%m-%d %H:%M %Z")


def _names(results: Sequence[RunResult], name_of: Callable[[RunResult], str | None]) -> str:
    return ", ".join(dict.fromkeys(name for name in map(name_of, results) if name))


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [(hours, "h"), (minutes, "min"), (rest, "s")]
    return " ".join(f"{count} {unit}" for count, unit in parts if count)
