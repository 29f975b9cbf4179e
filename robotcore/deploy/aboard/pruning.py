"""Old releases make room for new ones."""

from __future__ import annotations

import json
from collections.abc import Iterator

from robotcore.deploy.aboard import environments
from robotcore.deploy.aboard.incoming import throw_away
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.release import NAME

KEPT = 5


def names(layout: Layout) -> list[str]:
    """Return the names of all releases, the newest first."""
    found = layout.releases.glob("*")
    return sorted((folder.name for folder in found if NAME.fullmatch(folder.name)), reverse=True)


def current(layout: Layout) -> str | None:
    """Return the name of the release that runs, or would; nothing where none does."""
    try:
        return layout.current.readlink().name
    except OSError:
        return None


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
    """Yield the release that runs, the one to go back to, and those that a trial is about."""
    now = current(layout)
    yield now
    yield next((name for name in names(layout) if now and name < now), None)
    try:
        trial = json.loads(layout.trial.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return
    yield from (trial.get("release"), trial.get("previous"))
