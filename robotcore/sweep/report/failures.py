"""The failing runs, each with all that somebody needs to look into it."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from robotcore.outcome import Outcome, RunResult
from robotcore.sweep.record import Record


@dataclass(frozen=True)
class Failure:
    """A failing run in words; ``picture`` is a ``data:`` URI, empty where there is none."""

    title: str
    cause: str
    facts: tuple[str, ...]
    command: str
    picture: str = ""

    @classmethod
    def of(cls, record: Record, pictures: Path | None = None) -> Failure:
        """Return what is told of a run; its picture is looked for in ``pictures``."""
        picture = _embedded(pictures / record.picture) if pictures and record.picture else ""
        return cls(_title(record.result), _cause(record.result), tuple(_facts(record.result)), record.command, picture)


def _title(result: RunResult) -> str:
    seed = f"seed {result.seed}" if result.seed is not None else ""
    return " · ".join(part for part in (result.world, result.backend, seed) if part)


def _cause(result: RunResult) -> str:
    touched = f"touched something {_times(result.contacts)}" if result.contacts else ""
    return "; ".join(part for part in (_ending(result), touched) if part)


def _ending(result: RunResult) -> str:
    if result.outcome is not Outcome.SUCCESS:
        return f"{result.outcome.value}: {result.reason}" if result.reason else result.outcome.value
    return "says success, but the simulator does not agree" if result.verified is False else ""


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _facts(result: RunResult) -> Iterator[str]:
    """Yield how far the run got, and what was drawn for it."""
    if result.milestones:
        name, time = list(result.milestones.items())[-1]
        yield f"got as far as {name}, at {time:.1f} s"
    if result.distance_to_target_m is not None:
        yield f"ended {result.distance_to_target_m:.2f} m from the target"
    for name, value in result.conditions.items():
        yield f"{name} {value if isinstance(value, str) else f'{value:.3g}'}"


def _embedded(file: Path) -> str:
    with suppress(OSError):
        return f"data:image/png;base64,{b64encode(file.read_bytes()).decode()}"
    return ""
