"""The failing runs in the report: their endings, conditions and pictures."""

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
from robotcore.sweep.failure_analysis import SignificantSplit
from robotcore.sweep.record import GroupKey, Record, classify_failure, format_ending, format_failure
from robotcore.sweep.report.series import Series
from robotcore.sweep.statistics import subsample

MAX_DETAILED = 100
"""The maximum number of failing runs that the report shows with picture and conditions. They take about 3 MB."""

MAX_LISTED = 1000
"""The maximum number of other failing runs that the report lists without a picture."""

MAX_ENDINGS = 12
"""The maximum number of rows in the table of endings. A further row counts the runs with any other ending."""

MAX_WIDTH = 480
"""The maximum width of a picture in the report, in pixels."""

QUALITY = 80
"""The JPEG quality of a picture, from 0 to 100. A PNG would be larger, because it would keep the camera's noise."""


class Condition(NamedTuple):
    """A condition of a failing run, as text for the report."""

    name: str
    """The name of the condition."""

    value: str
    """The value of the condition in this run."""

    failing_side: str
    """The values with which more runs fail, such as ``light < 0.34``. Empty without a significant split."""


@dataclass(frozen=True)
class Failure:
    """A failing run, as texts for the report."""

    group: str
    """The world and the backend."""

    title: str
    """The world, the backend and the seed."""

    cause: str
    """Why the run counts as failing: its outcome, its reason and its contacts."""

    facts: tuple[str, ...]
    """A text about the last milestone, and one about the distance to the target. Both may be missing."""

    command: str
    """The shell command that repeats the run."""

    conditions: tuple[Condition, ...] = ()
    """The conditions of the run, those with a significant split first."""

    picture: str = ""
    """The picture as a ``data:`` URI; empty if there is none."""

    file: str = ""
    """The file of the picture, relative to the sweep's folder; empty if there is none."""

    @classmethod
    def build_brief(cls, record: Record) -> Failure:
        """Return a failing run without conditions and picture, for the list of runs."""
        result = record.result
        group = _format_group(record)
        title = group if result.seed is None else f"{group} · seed {result.seed}"
        return cls(group, title, format_failure(record), tuple(_list_facts(result)), record.command)

    @classmethod
    def build_full(cls, record: Record, folder: Path, splits: Sequence[SignificantSplit]) -> Failure:
        """Return a failing run with the conditions that the seed drew for it, and with its picture.

        folder: the folder of the sweep, which has the picture.
        splits: the significant splits of all groups. The run's conditions that belong to one are marked.
        """
        brief = cls.build_brief(record)
        sides = {each.condition: each.side for each in splits if each.group == GroupKey.of(record)}
        full = replace(brief, conditions=_sort_conditions(record.result.conditions, sides))
        picture = embed_picture(folder / record.picture) if record.picture else ""
        return replace(full, picture=picture, file=record.picture) if picture and record.picture else full


class FailureGroup(NamedTuple):
    """The failing runs of one backend in one world, for the report."""

    name: str
    """The world and the backend."""

    runs: int
    """The number of failing runs of the group."""

    detailed: tuple[Failure, ...]
    """The failing runs of the group that the report shows with picture and conditions."""


@dataclass(frozen=True)
class Failures:
    """All failing runs of a sweep, for the report."""

    runs: int
    """The number of failing runs."""

    groups: tuple[FailureGroup, ...]
    """The runs that the report shows with picture and conditions, a group for each backend in each world."""

    listed: tuple[Failure, ...]
    """The runs that the report lists without picture and conditions."""

    unlisted: int
    """The number of failing runs that are in neither `groups` nor `listed`."""

    @classmethod
    def of(cls, records: Sequence[Record], folder: Path, splits: Sequence[SignificantSplit]) -> Failures:
        """Return the failing runs of a sweep.

        records: all records of the sweep, sorted by world and backend.
        folder: the folder of the sweep, which has the pictures.
        splits: the significant splits of the failure analysis.
        """
        failing = [record for record in records if record.is_failure]
        chosen = set(subsample(range(len(failing)), MAX_DETAILED))
        full = [Failure.build_full(failing[at], folder, splits) for at in sorted(chosen)]
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
    if result.milestones:
        name, time = list(result.milestones.items())[-1]
        yield f"last milestone {name}, at {time:.1f} s"
    if result.distance_to_target_m is not None:
        yield f"ended {result.distance_to_target_m:.2f} m from the target"


def _sort_conditions(values: Mapping[str, float | str], sides: Mapping[str, str]) -> tuple[Condition, ...]:
    first = [name for name in sides if name in values]
    order = dict.fromkeys([*first, *values])
    return tuple(Condition(name, _format_value(values[name]), sides.get(name, "")) for name in order)


def _format_value(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


class Ending(NamedTuple):
    """An ending that failing runs have in common, and the number of these runs."""

    text: str
    """The outcome and its reason, such as ``timeout, not done after 20 s``."""

    runs: int
    """The number of runs with this ending."""

    counts: tuple[int, ...]
    """The number of runs with this ending in each series."""


def count_endings(series: Sequence[Series]) -> list[Ending]:
    """Return the endings of failing runs, the most frequent first.

    If there are more than `MAX_ENDINGS`, a last element counts the runs with any other ending.
    """
    tallies = [Counter(_describe_ending(record) for record in each.records if record.is_failure) for each in series]
    total: Counter[str] = sum(tallies, Counter())
    common = [text for text, _ in total.most_common(MAX_ENDINGS)]
    rows = [Ending(text, total[text], tuple(tally[text] for tally in tallies)) for text in common]
    rest = tuple(sum(tally.values()) - sum(tally[text] for text in common) for tally in tallies)
    ways = len(total) - len(common)
    return [*rows, Ending(f"in {ways} other way{'s' * (ways > 1)}", sum(rest), rest)] if ways else rows


def _describe_ending(record: Record) -> str:
    """Return the outcome and the reason of a run; ``contact`` if the run fails only because of its contacts."""
    text = classify_failure(record.result)
    return text if text == "contact" else format_ending(record.result)


def embed_picture(file: Path) -> str:
    """Return a picture file as a ``data:`` URI of a small JPEG; an empty text if the file is missing or damaged."""
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
