"""The failing runs, each with all that somebody needs to look into it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from robotcore.runtime.outcome import RunResult
from robotcore.sweep.explain import Finding
from robotcore.sweep.place import Place
from robotcore.sweep.record import Record
from robotcore.sweep.report.pictures import embedded
from robotcore.sweep.thinning import thinned
from robotcore.sweep.words import fault

MAX_TOLD = 100
"""With a picture and all that was drawn: some 3 MB."""

MAX_LISTED = 1000


class Condition(NamedTuple):
    """What a run was under; ``finding`` says on which side of it runs fail more, where it was found to matter."""

    name: str
    value: str
    finding: str


@dataclass(frozen=True)
class Failure:
    """A failing run in words; ``picture`` is a ``data:`` URI made from ``file``; both may be empty."""

    place: str
    title: str
    cause: str
    facts: tuple[str, ...]
    command: str
    conditions: tuple[Condition, ...] = ()
    picture: str = ""
    file: str = ""

    @classmethod
    def brief(cls, record: Record) -> Failure:
        """Return what fits into a list."""
        result = record.result
        place = _place(record)
        title = place if result.seed is None else f"{place} · seed {result.seed}"
        return cls(place, title, fault(record), tuple(_facts(result)), record.command)

    @classmethod
    def full(cls, record: Record, folder: Path, findings: Sequence[Finding]) -> Failure:
        """Return all; the picture is looked for in the sweep's ``folder``."""
        brief = cls.brief(record)
        here = {each.condition: each.where for each in findings if each.place == Place.of(record)}
        full = replace(brief, conditions=_conditions(record.result.conditions, here))
        picture = embedded(folder / record.picture) if record.picture else ""
        return replace(full, picture=picture, file=record.picture) if picture and record.picture else full


class Told(NamedTuple):
    """Of the failing runs of a place those that are told in full."""

    place: str
    runs: int
    some: tuple[Failure, ...]


@dataclass(frozen=True)
class Failures:
    """All failing runs: some told in full, by their places, others in a list, and how many are told nowhere."""

    runs: int
    told: tuple[Told, ...]
    listed: tuple[Failure, ...]
    untold: int

    @classmethod
    def of(cls, records: Sequence[Record], folder: Path, findings: Sequence[Finding]) -> Failures:
        """Return the failing ones of some records, which are sorted by their places."""
        failing = [record for record in records if record.is_failure]
        chosen = set(thinned(range(len(failing)), MAX_TOLD))
        full = [Failure.full(failing[at], folder, findings) for at in sorted(chosen)]
        others = [record for at, record in enumerate(failing) if at not in chosen]
        runs = Counter(map(_place, failing))
        told = tuple(
            Told(place, runs[place], tuple(some)) for place, some in groupby(full, key=lambda each: each.place)
        )
        listed = tuple(map(Failure.brief, others[:MAX_LISTED]))
        return cls(len(failing), told, listed, len(others) - len(listed))


def _place(record: Record) -> str:
    return " · ".join(part for part in (record.result.world, record.result.backend) if part)


def _facts(result: RunResult) -> Iterator[str]:
    """Yield how far the run got."""
    if result.milestones:
        name, time = list(result.milestones.items())[-1]
        yield f"got as far as {name}, at {time:.1f} s"
    if result.distance_to_target_m is not None:
        yield f"ended {result.distance_to_target_m:.2f} m from the target"


def _conditions(told: Mapping[str, float | str], findings: Mapping[str, str]) -> tuple[Condition, ...]:
    """Return what a run was under, what was found to matter first."""
    first = [name for name in findings if name in told]
    order = dict.fromkeys([*first, *told])
    return tuple(Condition(name, _value(told[name]), findings.get(name, "")) for name in order)


def _value(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"
