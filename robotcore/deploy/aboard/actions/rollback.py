"""Puts an earlier release in the place of the one that runs."""

from __future__ import annotations

from typing import Any

from robotcore.deploy.aboard import current, trial
from robotcore.deploy.aboard.actions import activate
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.release import NAME
from robotcore.deploy.aboard.telling import RefusalError
from robotcore.deploy.aboard.verdict import Verdict


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
    return activate.try_out(layout, name, healthy_within_s, settle_s)


def _before(layout: Layout) -> str:
    """Return the last healthy release that is older than the current one."""
    now = current.name_of(layout)
    names = sorted(folder.name for folder in layout.releases.glob("*") if NAME.fullmatch(folder.name))
    for name in reversed([name for name in names if now is None or name < now]):
        if (verdict := Verdict.read(layout.releases / name)) and verdict.is_healthy:
            return name
    raise RefusalError(
        f"no release before {now} was healthy" if now else "no release was healthy",
        f"Name one: {', '.join(name for name in names if name != now) or 'there is no other'}",
    )
