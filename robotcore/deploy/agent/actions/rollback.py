"""Puts an earlier release in the place of the one that runs."""

from __future__ import annotations

from typing import Any

from robotcore.deploy.agent.actions import activate
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.verdict import UNHEALTHY, Verdict
from robotcore.deploy.agent.telling import RefusalError, say
from robotcore.deploy.agent.trial import trial


def act(
    layout: Layout,
    *,
    release: str | None = None,
    healthy_within_s: float = trial.HEALTHY_WITHIN_S,
    settle_s: float = trial.SETTLE_S,
) -> dict[str, Any]:
    """Try a release that was there before, by default the last healthy one; return what came of it."""
    if release is not None and release not in current.names(layout):
        raise RefusalError(f"there is no release {release!r}", _those(current.names(layout)), "name")
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
    others = [name for name in current.names(layout) if name != now and not _is_known_to_fail(layout, name)]
    raise RefusalError(f"no release before {now} was healthy" if now else "no release was healthy", _those(others))


def _those(names: list[str]) -> str:
    return f"Name one: {', '.join(names)}" if names else "There is none to go back to; send one: robotcore deploy push"


def _is_known_to_fail(layout: Layout, name: str) -> bool:
    verdict = Verdict.read(layout.releases / name)
    return verdict is not None and verdict.outcome == UNHEALTHY
