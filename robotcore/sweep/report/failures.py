"""The failing runs in the report: their endings, facts, conditions and pictures."""

from __future__ import annotations

from base64 import b64encode
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from robotcore.sweep.failure_analysis import Split
from robotcore.sweep.record import GroupKey, Record, classify_failure, format_ending
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


def choose_failures(records: Sequence[Record]) -> dict[str, Any]:
    """Return which failing runs the report shows, as variables of the template ``failures.html.j2``.

    The result has a list ``(name of the group, number of its failing runs, runs to show in full)`` for each backend in
    each world, the runs to list in one line, and the number of the other failing runs.

    records: all records of the sweep, sorted by world and backend.
    """
    failing = [record for record in records if record.is_failure]
    chosen = set(subsample(range(len(failing)), MAX_DETAILED))
    others = [record for at, record in enumerate(failing) if at not in chosen]
    runs = Counter(map(format_group, failing))
    detailed = groupby((failing[at] for at in sorted(chosen)), format_group)
    return {
        "failing": len(failing),
        "detailed": [(name, runs[name], list(group)) for name, group in detailed],
        "listed": others[:MAX_LISTED],
        "unlisted": len(others[MAX_LISTED:]),
    }


def format_group(record: Record) -> str:
    """Return the world and the backend of a run as one text."""
    return " · ".join(part for part in (record.result.world, record.result.backend) if part)


def format_title(record: Record) -> str:
    """Return the world, the backend and the seed of a run as one text."""
    seed = record.result.seed
    return format_group(record) if seed is None else f"{format_group(record)} · seed {seed}"


def list_facts(record: Record) -> Iterator[str]:
    """Yield a text about the last milestone of a run, and one about its distance to the target, if they are known."""
    result = record.result
    if result.milestones:
        name, time = list(result.milestones.items())[-1]
        yield f"last milestone {name}, at {time:.1f} s"
    if result.distance_to_target_m is not None:
        yield f"ended {result.distance_to_target_m:.2f} m from the target"


def list_conditions(record: Record, splits: Sequence[Split]) -> list[tuple[str, str, str]]:
    """Return the name and the value of each condition of a run, and the side of its significant split if it has one.

    splits: the significant splits of all groups. The conditions that have one come first.
    """
    values = record.result.conditions
    sides = {each.condition: each.side for each in splits if each.group == GroupKey.from_record(record)}
    names = dict.fromkeys([*filter(values.__contains__, sides), *values])
    return [(name, _format_value(values[name]), sides.get(name, "")) for name in names]


def _format_value(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


def count_endings(series: Sequence[Series]) -> list[tuple[str, list[int]]]:
    """Return the endings of failing runs, such as ``timeout, not done after 20 s``, the most frequent first.

    Each ending has the number of its runs in each series. If there are more than `MAX_ENDINGS`, a last element counts
    the runs with any other ending.
    """
    tallies = [Counter(_describe_ending(record) for record in each.records if record.is_failure) for each in series]
    ordered = [text for text, _ in sum(tallies, Counter[str]()).most_common()]
    common, rare = ordered[:MAX_ENDINGS], ordered[MAX_ENDINGS:]
    rows = [(text, [tally[text] for tally in tallies]) for text in common]
    if rare:
        text = f"in {len(rare)} other way{'s' * (len(rare) > 1)}"
        rows.append((text, [sum(tally[each] for each in rare) for tally in tallies]))
    return rows


def _describe_ending(record: Record) -> str:
    """Return the outcome and the reason of a run; ``contact`` if the run fails only because of its contacts."""
    text = classify_failure(record.result)
    return text if text == "contact" else format_ending(record.result)


def embed_picture(file: Path) -> str:
    """Return a picture file as a ``data:`` URI of a small JPEG; an empty text if the file is missing or damaged."""
    with suppress(OSError, cv2.error):
        image = cv2.imdecode(np.frombuffer(file.read_bytes(), np.uint8), cv2.IMREAD_COLOR)
        if image is not None:
            scale = min(1.0, MAX_WIDTH / image.shape[1])
            small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
            _, encoded = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
            return f"data:image/jpeg;base64,{b64encode(encoded.tobytes()).decode()}"
    return ""
