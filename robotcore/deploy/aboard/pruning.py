"""Old releases make room for new ones."""

from __future__ import annotations

from collections.abc import Iterator

from robotcore.deploy.aboard import current, environments, trial
from robotcore.deploy.aboard.incoming import throw_away
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.release import NAME
from robotcore.deploy.aboard.verdict import Verdict

KEPT = 5


def names(layout: Layout) -> list[str]:
    """Return the names of all releases, the newest first."""
    found = layout.releases.glob("*")
    return sorted((folder.name for folder in found if NAME.fullmatch(folder.name)), reverse=True)


def prune(layout: Layout, keep: int = KEPT) -> tuple[str, ...]:
    """Throw away all but the newest releases and those that are needed, and environments nobody uses; return which.

    The caller holds the lock.
    """
    needed = set(_needed(layout))
    old = [name for name in names(layout)[keep:] if name not in needed]
    for name in old:
        throw_away(layout, layout.releases / name)
    environments.discard_unused(layout)
    return tuple(old)


def _needed(layout: Layout) -> Iterator[str | None]:
    """Yield the release that runs, the healthy one to go back to from it, and those that a trial is about."""
    now, tried = current.name_of(layout), trial.pending(layout)
    yield now
    yield next((name for name in names(layout) if now and name < now and _was_healthy(layout, name)), None)
    if tried:
        yield from (tried.release, tried.previous)


def _was_healthy(layout: Layout, name: str) -> bool:
    verdict = Verdict.read(layout.releases / name)
    return bool(verdict and verdict.is_healthy)
