"""Old releases make room for new ones."""

from __future__ import annotations

from collections.abc import Iterator

from robotcore.deploy.agent.environment import environments
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.incoming import throw_away
from robotcore.deploy.agent.trial import trial

KEPT, FAILED = 5, 2
"""So many healthy releases stay, and so many others, to be looked at: what fails pushes out nothing that lives."""


def prune(layout: Layout, keep: int = KEPT) -> tuple[str, ...]:
    """Throw away all but the newest releases and those that are needed, and environments nobody uses; return which.

    The caller holds the lock.
    """
    healthy = [name for name in current.names(layout) if current.is_healthy(layout, name)]
    others = [name for name in current.names(layout) if name not in healthy]
    stay = {*healthy[:keep], *others[: min(keep, FAILED)], *_needed(layout)}
    old = [name for name in current.names(layout) if name not in stay]
    for name in old:
        throw_away(layout, layout.releases / name)
    environments.discard_unused(layout)
    return tuple(old)


def _needed(layout: Layout) -> Iterator[str | None]:
    """Yield the release that runs, the healthy one to go back to from it, and those that a trial is about."""
    yield current.name_of(layout)
    yield current.before(layout)
    if tried := trial.pending(layout):
        yield from (tried.release, tried.previous)
