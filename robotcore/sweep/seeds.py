"""Seeds as they are written: ``7``, ``1-200``, ``1,5,9-12``."""

from __future__ import annotations

import re

from robotcore.errors import UsageError

_RANGE = re.compile(r"(\d+)(?:\s*-\s*(\d+))?")


def seeds_of(text: str) -> tuple[int, ...]:
    """Return the seeds in the order they are written, each once."""
    return tuple(dict.fromkeys(seed for part in text.split(",") for seed in _range(text, part.strip())))


def _range(text: str, part: str) -> range:
    found = _RANGE.fullmatch(part)
    if not found:
        raise UsageError(f"--seeds {text}: {part!r} is no seed. Write 7, or 1-200, or 1,5,9-12")
    first, last = int(found[1]), int(found[2] or found[1])
    if last < first:
        raise UsageError(f"--seeds {text}: {part} runs backwards. Write {last}-{first}")
    return range(first, last + 1)
