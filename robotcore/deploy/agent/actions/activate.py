"""Puts a release in the place of the one that runs, and keeps it there if it lives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.release import require_name
from robotcore.deploy.agent.releases.verdict import Verdict
from robotcore.deploy.agent.service import systemd, upkeep
from robotcore.deploy.agent.service.units import SERVICE, START_LIMIT_S, TRIAL
from robotcore.deploy.agent.system.locking import locked
from robotcore.deploy.agent.telling import RefusalError
from robotcore.deploy.agent.trial import trial
from robotcore.deploy.agent.trial.following import follow, settled, told
from robotcore.deploy.agent.trial.trial import Trial


def act(
    layout: Layout,
    *,
    release: str,
    healthy_within_s: float = trial.HEALTHY_WITHIN_S,
    settle_s: float = trial.SETTLE_S,
) -> dict[str, Any]:
    """Try a release; return what came of it, as `following.told` does.

    May be called again after a lost connection: what is known of the release is told, and a trial that is under way is
    looked at. Nothing that happens to this call changes the trial. Raises RefusalError where the release cannot be
    tried; then nothing has changed.
    """
    known = Verdict.read(_folder(layout, release))
    is_over = known and (current.name_of(layout) == release or not known.is_healthy)
    if known and is_over and not trial.pending(layout):
        return told(layout, release, known)
    return try_out(layout, release, healthy_within_s, settle_s)


def try_out(layout: Layout, release: str, healthy_within_s: float, settle_s: float) -> dict[str, Any]:
    """Try a release, whatever is known of it."""
    _require_possible(layout, release, healthy_within_s)
    under_way = trial.pending(layout)
    if under_way and under_way.release == release:
        systemd.start(TRIAL)
        return follow(layout, under_way)
    with locked(layout, f"release {release} is put in place"):
        before = _to_go_back_to(layout, release)
        begun = replace(before, healthy_within_s=healthy_within_s, settle_s=settle_s, since=trial.now())
        upkeep.ensure(layout)
        begun.begin(layout)
    return follow(layout, begun)


def _require_possible(layout: Layout, release: str, healthy_within_s: float) -> None:
    if not 0 < healthy_within_s <= START_LIMIT_S:
        raise RefusalError(
            f"a release cannot be given {healthy_within_s:g} s to come up", f"Give it up to {START_LIMIT_S} s"
        )
    if not _folder(layout, release).is_dir():
        raise RefusalError(f"there is no release {release}", "See what there is: robotcore deploy list")


def _folder(layout: Layout, release: str) -> Path:
    """Return where a release is, or would be; raises RefusalError where the name is none."""
    try:
        return layout.releases / require_name(release)
    except ValueError as error:
        raise RefusalError(f"{release!r} is no release", "See what there is: robotcore deploy list") from error


def _to_go_back_to(layout: Layout, release: str) -> Trial:
    """Return a trial with the release that is there again if this one is not healthy, and how that one is now.

    It is never one that was not judged to the end.
    """
    if unjudged := trial.pending(layout):
        found = replace(unjudged, release=release)
    else:
        state = systemd.show(SERVICE)
        if state.is_between and not state.is_starting:  # whether it will be started again is known once it has ended
            state = settled()
        is_standing = not (state.is_up or state.is_starting)
        found = Trial(release, current.name_of(layout), was_standing=is_standing, was_enabled=state.is_enabled)
    return replace(found, previous=current.before(layout)) if found.previous == release else found
