"""Actions on what runs: activate, roll back, start and stop a release, read its status and its log."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from robotcore.deploy.agent import health_check, journal, releases, robot_facts, systemd, units
from robotcore.deploy.agent.files import Layout, measure_free_space
from robotcore.deploy.agent.health_check import HealthCheck
from robotcore.deploy.agent.health_report import build_report, follow_check, wait_until_settled
from robotcore.deploy.agent.lock import hold_lock
from robotcore.deploy.agent.releases import UNHEALTHY, HealthResult, require_name
from robotcore.deploy.agent.rpc import AgentError, report_progress
from robotcore.deploy.agent.systemd import UnitState
from robotcore.deploy.agent.units import HEALTH_CHECK, SERVICE, START_LIMIT_S, list_installed_units


def activate_release(
    layout: Layout,
    *,
    release: str,
    healthy_within_s: float = health_check.HEALTHY_WITHIN_S,
    settle_s: float = health_check.SETTLE_S,
) -> dict[str, Any]:
    """Try a release; return what came of it, as `following.told` does.

    May be called again after a lost connection: what is known of the release is told, and a trial that is under way is
    looked at. Nothing that happens to this call changes the trial. Raises RefusalError where the release cannot be
    tried; then nothing has changed.
    """
    known = HealthResult.read(_find_folder(layout, release))
    is_over = known and (releases.read_current(layout) == release or not known.is_healthy)
    if known and is_over and not health_check.read_pending(layout):
        return build_report(layout, release, known)
    return start_check(layout, release, healthy_within_s, settle_s)


def start_check(layout: Layout, release: str, healthy_within_s: float, settle_s: float) -> dict[str, Any]:
    """Try a release, whatever is known of it."""
    _require_possible(layout, release, healthy_within_s)
    under_way = health_check.read_pending(layout)
    if under_way and under_way.release == release:
        systemd.start(HEALTH_CHECK)
        return follow_check(layout, under_way)
    with hold_lock(layout, f"release {release} is put in place"):
        before = _plan_check(layout, release)
        begun = replace(before, healthy_within_s=healthy_within_s, settle_s=settle_s, since=health_check.format_now())
        units.install_service(layout)
        begun.begin(layout)
    return follow_check(layout, begun)


def _require_possible(layout: Layout, release: str, healthy_within_s: float) -> None:
    if not 0 < healthy_within_s <= START_LIMIT_S:
        raise AgentError(
            f"a release cannot be given {healthy_within_s:g} s to come up",
            f"Give it up to {START_LIMIT_S} s",
            "time-limit",
            limit_s=START_LIMIT_S,
        )
    if not _find_folder(layout, release).is_dir():
        raise AgentError(f"there is no release {release}", "List the releases: robotcore deploy list", "no-release")


def _find_folder(layout: Layout, release: str) -> Path:
    """Return where a release is, or would be; raises RefusalError where the name is none."""
    try:
        return layout.releases / require_name(release)
    except ValueError as error:
        raise AgentError(
            f"{release!r} is no release", "List the releases: robotcore deploy list", "release-name"
        ) from error


def _plan_check(layout: Layout, release: str) -> HealthCheck:
    """Return a trial with the release that is there again if this one is not healthy, and how that one is now.

    It is never one that was not judged to the end.
    """
    if unjudged := health_check.read_pending(layout):
        found = replace(unjudged, release=release)
    else:
        state = systemd.read_state(SERVICE)
        if state.is_between and not state.is_starting:  # whether it will be started again is known once it has ended
            state = wait_until_settled()
        is_standing = not (state.is_up or state.is_starting)
        found = HealthCheck(
            release, releases.read_current(layout), was_standing=is_standing, was_enabled=state.is_enabled
        )
    return replace(found, previous=releases.find_previous(layout)) if found.previous == release else found


def roll_back(
    layout: Layout,
    *,
    release: str | None = None,
    healthy_within_s: float = health_check.HEALTHY_WITHIN_S,
    settle_s: float = health_check.SETTLE_S,
) -> dict[str, Any]:
    """Try a release that was there before, by default the last healthy one; return what came of it."""
    names = releases.list_names(layout)
    if release is not None and release not in names:
        raise AgentError(f"there is no release {release!r}", _list_choices(names), "name", choices=names)
    name = release or _choose_previous(layout)
    if name == releases.read_current(layout):
        raise AgentError(f"{name} is the current release", "Start it: robotcore deploy start", "already-current")
    report_progress(f"{name} is to run again", release=name)  # who loses the connection knows by it what to look for
    return start_check(layout, name, healthy_within_s, settle_s)


def _choose_previous(layout: Layout) -> str:
    """Return the last healthy release that is older than the current one."""
    if name := releases.find_previous(layout):
        return name
    now = releases.read_current(layout)
    others = [name for name in releases.list_names(layout) if name != now and not _is_unhealthy(layout, name)]
    fault = f"no release before {now} was healthy" if now else "no release was healthy"
    raise AgentError(fault, _list_choices(others), "no-healthy-release", current=now, choices=others)


def _list_choices(names: list[str]) -> str:
    return f"Name one: {', '.join(names)}" if names else "There is none to go back to; send one: robotcore deploy push"


def _is_unhealthy(layout: Layout, name: str) -> bool:
    verdict = HealthResult.read(layout.releases / name)
    return verdict is not None and verdict.outcome == UNHEALTHY


def start_app(layout: Layout) -> dict[str, Any]:
    """Start it; return the status once it is up, or is not. One whose trial broke off is judged."""
    if releases.read_current(layout) is None:
        raise AgentError("there is no release to start", "Send one: robotcore deploy push", "no-current-release")
    with hold_lock(layout, "the app is started"):
        units.install_service(layout)
        tried = health_check.read_pending(layout)
        systemd.start(HEALTH_CHECK if tried else SERVICE)
    if tried:
        follow_check(layout, tried)
    wait_until_settled()
    return read_status(layout)


def stop_app(layout: Layout) -> dict[str, Any]:
    """Stop it, whoever else is at work; return the status. Where nothing was put, nothing is done.

    A release that is on trial is not judged any more; the one before is the current one, and stands too.
    """
    if list_installed_units(layout):
        systemd.stop(SERVICE, HEALTH_CHECK)
        systemd.stop(SERVICE)  # which the trial may have started once more
        systemd.disable(SERVICE)
        health_check.abandon_check(layout)
    return read_status(layout)


def read_status(layout: Layout) -> dict[str, Any]:
    """Return what runs, and how.

    ``state`` is running, starting, stopping, restarting, ended, failed or stopped; ``for_s`` how long it has been
    running, None where it is not; ``words`` what the app last said of itself, unless it is stopped. ``reason`` and
    ``lines`` tell of a failure, the last one where it was started again after it. ``on_trial`` names the release on
    trial. Where no release is in place, ``last`` is the newest that was tried, by its ``name``, with ``outcome`` and
    ``reason``.
    """
    state, name, tried = systemd.read_state(SERVICE), releases.read_current(layout), health_check.read_pending(layout)
    word = _name_state(state)
    reason, lines = _explain_failure(state)
    return {
        "release": name,
        "verdict": _read_outcome(layout, name),
        "on_trial": tried.release if tried else None,
        "last": None if name else _read_last_check(layout),
        "state": word,
        "for_s": time.monotonic() - state.active_since_s if state.is_up else None,
        "restarts": state.restarts,
        "words": "" if word == "stopped" else state.words,  # of whichever release ran last
        "reason": reason,
        "lines": lines,
        "starts_with_robot": state.is_enabled,
        "lingers": robot_facts.is_lingering(),
        "recordings": _measure_recordings(layout),
        "free_bytes": measure_free_space(layout.home),
    }


def _name_state(state: UnitState) -> str:
    if state.sub == "auto-restart":
        return "restarting"
    if state.has_failed:
        return "failed"
    if state.has_succeeded and state.invocation:
        return "ended"
    return {"active": "running", "activating": "starting", "deactivating": "stopping"}.get(state.active, "stopped")


def _explain_failure(state: UnitState) -> tuple[str, list[str]]:
    if state.has_failed:
        reason, invocation = state.ending(), state.invocation
    elif state.restarts and (ended := journal.read_last_end(SERVICE)):
        reason, invocation = ended
    else:
        return "", []
    return reason, list(journal.read_last_lines(SERVICE, invocation))


def _read_outcome(layout: Layout, name: str | None) -> str | None:
    verdict = HealthResult.read(layout.releases / name) if name else None
    return verdict.outcome if verdict else None


def _read_last_check(layout: Layout) -> dict[str, str] | None:
    for name in releases.list_names(layout):
        if verdict := HealthResult.read(layout.releases / name):
            return {"name": name, "outcome": verdict.outcome, "reason": verdict.reason}
    return None


def _measure_recordings(layout: Layout) -> dict[str, int]:
    sizes = [size for file in layout.recordings.glob("*.mcap") if (size := file.stat().st_size)]
    return {"files": len(sizes), "bytes": sum(sizes)}


def print_log(layout: Layout, *, lines: int = 50, follow: bool = False) -> dict[str, Any]:  # noqa: ARG001  as all do
    """Print the last ``lines``, each as it is, without our mark; then, where they are followed, what comes."""
    journal.print_lines(SERVICE, lines, is_followed=follow)
    return {}
