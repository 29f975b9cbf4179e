"""Puts an earlier release in the place of the one that runs."""

from __future__ import annotations

from typing import Any

from robotcore.deploy.aboard.actions import activate
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.releases import current
from robotcore.deploy.aboard.telling import RefusalError, say
from robotcore.deploy.aboard.trial import trial


def act(
    layout: Layout,
    *,
    release: str | None = None,
    healthy_within_s: float = trial.HEALTHY_WITHIN_S,
    settle_s: float = trial.SETTLE_S,
) -> dict[str, Any]:
    """Try a release that was there before, by default the last healthy one; return what came of it."""
    name = release or _before(layout)
    if name == current.name_of(layout):
        raise RefusalError(f"{name} is the current release", "To start it: robotcore deploy start")
    say(f"{name} is to run again", release=name)  # who loses the connection knows by it what to look for
    return activate.try_out(layout, name, healthy_within_s, settle_s)


def _before(layout: Layout) -> str:
    """Return the last healthy release that is older than the current one."""
    if name := current.before(layout):
        return name
    now = current.name_of(layout)
    others = ", ".join(name for name in current.names(layout) if name != now)
    raise RefusalError(
        f"no release before {now} was healthy" if now else "no release was healthy",
        f"Name one: {others}" if others else "There is no other; send one: robotcore deploy push",
    )
