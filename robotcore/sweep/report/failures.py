"""The failing runs of a report: how they end, their conditions and their pictures."""

from __future__ import annotations

from base64 import b64encode
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from robotcore.hal.devices import Image
from robotcore.runtime.result import RunResult
from robotcore.sweep.failure_analysis import Finding
from robotcore.sweep.record import GroupKey, Record, classify_failure, format_ending, format_failure
from robotcore.sweep.report.series import Series
from robotcore.sweep.statistics import subsample

MAX_DETAILED = 100
"""With a picture and all that was drawn: some 3 MB."""

MAX_LISTED = 1000

MAX_ENDINGS = 12
"""The most endings in the table; the others are counted as one row."""

MAX_WIDTH = 480
QUALITY = 80
"""Of a JPEG. A camera's noise, which makes a PNG big, is not what one looks at a failing run for."""


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
        place = _format_place(record)
        title = place if result.seed is None else f"{place} · seed {result.seed}"
        return cls(place, title, format_failure(record), tuple(_list_facts(result)), record.command)

    @classmethod
    def full(cls, record: Record, folder: Path, findings: Sequence[Finding]) -> Failure:
        """Return all; the picture is looked for in the sweep's ``folder``."""
        brief = cls.brief(record)
        here = {each.condition: each.where for each in findings if each.place == GroupKey.of(record)}
        full = replace(brief, conditions=_sort_conditions(record.result.conditions, here))
        picture = embed_picture(folder / record.picture) if record.picture else ""
        return replace(full, picture=picture, file=record.picture) if picture and record.picture else full


class FailureGroup(NamedTuple):
    """The failing runs of one backend and world that are shown in full."""

    place: str
    runs: int
    some: tuple[Failure, ...]


@dataclass(frozen=True)
class Failures:
    """All failing runs: some in full, by backend and world, others in a list, and the number of the rest."""

    runs: int
    groups: tuple[FailureGroup, ...]
    listed: tuple[Failure, ...]
    unlisted: int

    @classmethod
    def of(cls, records: Sequence[Record], folder: Path, findings: Sequence[Finding]) -> Failures:
        """Return the failing ones of some records, which are sorted by their places."""
        failing = [record for record in records if record.is_failure]
        chosen = set(subsample(range(len(failing)), MAX_DETAILED))
        full = [Failure.full(failing[at], folder, findings) for at in sorted(chosen)]
        others = [record for at, record in enumerate(failing) if at not in chosen]
        runs = Counter(map(_format_place, failing))
        groups = tuple(
            FailureGroup(place, runs[place], tuple(some)) for place, some in groupby(full, key=lambda each: each.place)
        )
        listed = tuple(map(Failure.brief, others[:MAX_LISTED]))
        return cls(len(failing), groups, listed, len(others) - len(listed))


def _format_place(record: Record) -> str:
    return " · ".join(part for part in (record.result.world, record.result.backend) if part)


def _list_facts(result: RunResult) -> Iterator[str]:
    """Yield how far the run got."""
    if result.milestones:
        name, time = list(result.milestones.items())[-1]
        yield f"got as far as {name}, at {time:.1f} s"
    if result.distance_to_target_m is not None:
        yield f"ended {result.distance_to_target_m:.2f} m from the target"


def _sort_conditions(values: Mapping[str, float | str], findings: Mapping[str, str]) -> tuple[Condition, ...]:
    """Return what a run was under, what was found to matter first."""
    first = [name for name in findings if name in values]
    order = dict.fromkeys([*first, *values])
    return tuple(Condition(name, _format_value(values[name]), findings.get(name, "")) for name in order)


def _format_value(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


class Ending(NamedTuple):
    """A way to fail; ``counts`` has a number for each of the series."""

    text: str
    runs: int
    counts: tuple[int, ...]


def count_endings(series: Sequence[Series]) -> list[Ending]:
    """Return the ways in which runs fail, the most frequent first."""
    tallies = [Counter(_describe_ending(record) for record in each.records if record.is_failure) for each in series]
    total: Counter[str] = sum(tallies, Counter())
    common = [text for text, _ in total.most_common(MAX_ENDINGS)]
    rows = [Ending(text, total[text], tuple(tally[text] for tally in tallies)) for text in common]
    rest = tuple(sum(tally.values()) - sum(tally[text] for text in common) for tally in tallies)
    ways = len(total) - len(common)
    return [*rows, Ending(f"in {ways} other way{'s' * (ways > 1)}", sum(rest), rest)] if ways else rows


def _describe_ending(record: Record) -> str:
    """Return how a run ended; or that it touched something, where it succeeded but for that."""
    text = classify_failure(record.result)
    return text if text == "contact" else format_ending(record.result)


def embed_picture(file: Path) -> str:
    """Return a picture's file as a ``data:`` URI of a small JPEG; empty where there is none that can be read."""
    with suppress(OSError, cv2.error):
        image = cv2.imdecode(np.frombuffer(file.read_bytes(), np.uint8), cv2.IMREAD_COLOR)
        if image is not None:
            return _encode_jpeg(_narrow(np.asarray(image, np.uint8)))
    return ""


def _encode_jpeg(image: Image) -> str:
    _, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return f"data:image/jpeg;base64,{b64encode(encoded.tobytes()).decode()}"


def _narrow(image: Image) -> Image:
    height, width = image.shape[:2]
    if width <= MAX_WIDTH:
        return image
    size = MAX_WIDTH, round(height * MAX_WIDTH / width)
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
