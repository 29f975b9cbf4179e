"""Seeds as they are written: ``7``, ``1-200``, ``1,5,9-12``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import chain

from robotcore.errors import UsageError

MAX_SEEDS = 1_000_000
"""Requests are kept in memory; and so many runs take a core three weeks."""

_RANGE = re.compile(r"(\d{1,18})(?:\s*-\s*(\d{1,18}))?")


def seeds_of(text: str) -> tuple[int, ...]:
    """Return the seeds in the order they are written, each once."""
    ranges = [_range(text, part.strip()) for part in text.split(",")]
    if sum(map(len, ranges)) > MAX_SEEDS:
        raise UsageError(f"--seeds {text}: more than {MAX_SEEDS:,} seeds. Take fewer, in several sweeps if need be")
    return tuple(dict.fromkeys(chain.from_iterable(ranges)))


def seeds_told(seeds: Sequence[int]) -> str:
    """Return how seeds are written: what `seeds_of` takes."""
    ranges: list[list[int]] = []
    for seed in seeds:
        if ranges and seed == ranges[-1][-1] + 1:
            ranges[-1][1:] = [seed]
        else:
            ranges.append([seed])
    return ",".join("-".join(map(str, ends)) for ends in ranges)


def _range(text: str, part: str) -> range:
    found = _RANGE.fullmatch(part)
    if not found:
        raise UsageError(f"--seeds {text}: {part!r} is no seed. Write 7, or 1-200, or 1,5,9-12")
    first, last = int(found[1]), int(found[2] or found[1])
    if last < first:
        raise UsageError(f"--seeds {text}: {part} runs backwards. Write {last}-{first}")
    return range(first, last + 1)
