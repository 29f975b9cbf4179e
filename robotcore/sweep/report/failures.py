"""The failing runs of a report: their endings, conditions and pictures."""

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
"""The report shows at most this many failing runs with a picture and all conditions. They take about 3 MB."""

MAX_LISTED = 1000
"""The report lists at most this many other failing runs, without a picture."""

MAX_ENDINGS = 12
"""The table shows at most this many endings. One more row counts all others."""

MAX_WIDTH = 480
"""The width of a picture, in pixels."""

QUALITY = 80
"""The quality of a JPEG. A PNG would be larger, because it would keep the noise of the camera."""


class Condition(NamedTuple):
    """A condition of a failing run."""

    name: str
    """The name of the condition."""

    value: str
    """The value of the condition in this run, as text."""

    finding: str
    """The values with which more runs fail, such as ``light < 0.34``; empty if the analysis found none."""


@dataclass(frozen=True)
class Failure:
    """The texts of a report about one failing run."""

    group: str
    """The world and the backend."""

    title: str
    """The world, the backend and the seed."""

    cause: str
    """The outcome, its reason, and the contacts."""

    facts: tuple[str, ...]
    """The last milestone, and the distance to the target."""

    command: str
    """The command that repeats the run."""

    conditions: tuple[Condition, ...] = ()
    """The conditions, those with a finding first."""

    picture: str = ""
    """The picture as a ``data:`` URI; empty if there is none."""

    file: str = ""
    """The file of the picture, relative to the sweep's folder; empty if there is none."""

    @classmethod
    def build_brief(cls, record: Record) -> Failure:
        """Return the texts about a failing run without conditions and picture, for the list of runs."""
        result = record.result
        group = _format_group(record)
        title = group if result.seed is None else f"{group} · seed {result.seed}"
        return cls(group, title, format_failure(record), tuple(_list_facts(result)), record.command)

    @classmethod
    def build_full(cls, record: Record, folder: Path, findings: Sequence[Finding]) -> Failure:
        """Return the texts about a failing run with its conditions, and its picture from the sweep's ``folder``."""
        brief = cls.build_brief(record)
        sides = {each.condition: each.side for each in findings if each.group == GroupKey.of(record)}
        full = replace(brief, conditions=_sort_conditions(record.result.conditions, sides))
        picture = embed_picture(folder / record.picture) if record.picture else ""
        return replace(full, picture=picture, file=record.picture) if picture and record.picture else full


class FailureGroup(NamedTuple):
    """The failing runs of one backend in one world."""

    name: str
    """The world and the backend."""

    runs: int
    """The number of all failing runs of the group."""

    detailed: tuple[Failure, ...]
    """The runs of the group that are shown in full."""


@dataclass(frozen=True)
class Failures:
    """All failing runs of a sweep."""

    runs: int
    """The number of failing runs."""

    groups: tuple[FailureGroup, ...]
    """The runs that are shown in full, by backend and world."""

    listed: tuple[Failure, ...]
    """The runs that are only listed."""

    unlisted: int
    """The number of the other runs."""

    @classmethod
    def of(cls, records: Sequence[Record], folder: Path, findings: Sequence[Finding]) -> Failures:
        """Return the failing runs of records that are sorted by world and backend.

        records: the records of the sweep, passing ones too.
        folder: the sweep's folder, which has the pictures.
        findings: the findings of the failure analysis.
        """
        failing = [record for record in records if record.is_failure]
        chosen = set(subsample(range(len(failing)), MAX_DETAILED))
        full = [Failure.build_full(failing[at], folder, findings) for at in sorted(chosen)]
        others = [record for at, record in enumerate(failing) if at not in chosen]
        runs = Counter(map(_format_group, failing))
        groups = tuple(
            FailureGroup(name, runs[name], tuple(detailed))
            for name, detailed in groupby(full, key=lambda each: each.group)
        )
        listed = tuple(map(Failure.build_brief, others[:MAX_LISTED]))
        return cls(len(failing), groups, listed, len(others) - len(listed))


def _format_group(record: Record) -> str:
    return " · ".join(part for part in (record.result.world, record.result.backend) if part)


def _list_facts(result: RunResult) -> Iterator[str]:
    """Yield a text about the last milestone, and one about the distance to the target."""
    if result.milestones:
        name, time = list(result.milestones.items())[-1]
        yield f"last milestone {name}, at {time:.1f} s"
    if result.distance_to_target_m is not None:
        yield f"ended {result.distance_to_target_m:.2f} m from the target"


def _sort_conditions(values: Mapping[str, float | str], sides: Mapping[str, str]) -> tuple[Condition, ...]:
    """Return the conditions of a run, those with a finding first."""
    first = [name for name in sides if name in values]
    order = dict.fromkeys([*first, *values])
    return tuple(Condition(name, _format_value(values[name]), sides.get(name, "")) for name in order)


def _format_value(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


class Ending(NamedTuple):
    """A way in which failing runs ended, and the number of those runs."""

    text: str
    """The outcome and its reason."""

    runs: int
    """The number of runs that ended in this way."""

    counts: tuple[int, ...]
    """The number of those runs in each series."""


def count_endings(series: Sequence[Series]) -> list[Ending]:
    """Return the endings of failing runs, the most frequent first.

    There are at most `MAX_ENDINGS` endings. A further row counts the runs with any other ending.
    """
    tallies = [Counter(_describe_ending(record) for record in each.records if record.is_failure) for each in series]
    total: Counter[str] = sum(tallies, Counter())
    common = [text for text, _ in total.most_common(MAX_ENDINGS)]
    rows = [Ending(text, total[text], tuple(tally[text] for tally in tallies)) for text in common]
    rest = tuple(sum(tally.values()) - sum(tally[text] for text in common) for tally in tallies)
    ways = len(total) - len(common)
    return [*rows, Ending(f"in {ways} other way{'s' * (ways > 1)}", sum(rest), rest)] if ways else rows


def _describe_ending(record: Record) -> str:
    """Return the outcome of a run and its reason; ``contact`` if the run fails only because of its contacts."""
    text = classify_failure(record.result)
    return text if text == "contact" else format_ending(record.result)


def embed_picture(file: Path) -> str:
    """Return a picture as a ``data:`` URI of a small JPEG; an empty text if the file is missing or damaged."""
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
