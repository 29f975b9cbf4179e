"""Actions on the app: activate or roll back a release, start and stop the app, read its status and log."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import replace
from typing import Any

from robotcore.deploy.agent import health_check, journal, releases, robot_facts
from robotcore.deploy.agent import systemctl as systemd
from robotcore.deploy.agent import systemd_units as units
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout, hold_lock, measure_free_space, measure_recording
from robotcore.deploy.agent.health_check import HealthCheck, build_health_answer, follow_check, wait_until_settled
from robotcore.deploy.agent.releases import (
    HEALTHY,
    HEALTHY_WITHIN_S,
    UNHEALTHY,
    HealthResult,
    Release,
    read_outcome,
)
from robotcore.deploy.agent.rpc import report_progress
from robotcore.deploy.agent.systemctl import UnitState
from robotcore.deploy.agent.systemd_units import HEALTH_CHECK, SERVICE, START_LIMIT_S, list_installed_units


def activate_release(layout: Layout, *, release: str, healthy_within_s: float = HEALTHY_WITHIN_S) -> dict[str, Any]:
    """Make a release the current one if its health check passes. Return `build_health_answer`'s report.

    A second call for the same release follows the running check, or returns the stored result. An interrupt of the call
    does not end the check. If the release cannot be checked, the function raises AgentError and changes nothing.
    """
    names = releases.list_names(layout)
    if release not in names:
        raise _build_unknown_release_error(release, names)
    result = HealthResult.read(layout.releases / release)
    is_over = result and (releases.read_current(layout) == release or result.outcome != HEALTHY)
    if result and is_over and not health_check.read_pending(layout):
        return build_health_answer(layout, release, result)
    return start_check(layout, release, healthy_within_s)


def start_check(layout: Layout, release: str, healthy_within_s: float) -> dict[str, Any]:
    """Check the health of a release, even if it has a stored result. Return `build_health_answer`'s report."""
    if not 0 < healthy_within_s <= START_LIMIT_S:
        raise AgentError(
            f"a time limit of {healthy_within_s:g} s is not possible",
            f"Choose more than 0 s, and at most {START_LIMIT_S} s",
            "time-limit",
            limit_s=START_LIMIT_S,
        )
    pending = health_check.read_pending(layout)
    if pending and pending.release == release:
        systemd.start(HEALTH_CHECK)
        return follow_check(layout, pending)
    with hold_lock(layout, f"activation of {release}"):
        plan, since = _plan_check(layout, release), time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        check = replace(plan, healthy_within_s=healthy_within_s, since=since)
        units.install_service(layout)
        check.begin(layout)
    return follow_check(layout, check)


def _build_unknown_release_error(release: str, names: list[str]) -> AgentError:
    return AgentError(f"there is no release {release!r}", _list_choices(names), "name", choices=names)


def _plan_check(layout: Layout, release: str) -> HealthCheck:
    if pending := health_check.read_pending(layout):  # its release is not healthy yet, so keep its previous release
        plan = replace(pending, release=release)
    else:
        state = systemd.read_state(SERVICE)
        if state.is_changing and state.active != "activating":
            # only after the stop is it known whether systemd restarts the app
            state = wait_until_settled()
        is_standing = state.active not in {"active", "activating"}
        plan = HealthCheck(
            release, releases.read_current(layout), was_standing=is_standing, was_enabled=state.is_enabled
        )
    return replace(plan, previous=releases.find_previous(layout)) if plan.previous == release else plan


def roll_back(
    layout: Layout, *, release: str | None = None, healthy_within_s: float = HEALTHY_WITHIN_S
) -> dict[str, Any]:
    """Make an older release the current one if its health check passes. Return `build_health_answer`'s report.

    release: the release's name; None for the newest healthy release before the current one.
    """
    names = releases.list_names(layout)
    if release is not None and release not in names:
        raise _build_unknown_release_error(release, names)
    name = release or _choose_previous(layout)
    if name == releases.read_current(layout):
        raise AgentError(f"{name} is the current release", "Start it: robotcore deploy start", "already-current")
    # after the connection broke, the client asks for the result by this name
    report_progress(f"going back to {name}", release=name)
    return start_check(layout, name, healthy_within_s)


def _choose_previous(layout: Layout) -> str:
    if name := releases.find_previous(layout):
        return name
    now = releases.read_current(layout)
    others = [name for name in releases.list_names(layout) if name != now and read_outcome(layout, name) != UNHEALTHY]
    problem = f"no release before {now} was healthy" if now else "no release was healthy"
    raise AgentError(problem, _list_choices(others), "no-healthy-release", current=now, choices=others)


def _list_choices(names: list[str]) -> str:
    return f"Name one: {', '.join(names)}" if names else "The robot has no other one. Send one: robotcore deploy push"


def start_app(layout: Layout) -> dict[str, Any]:
    """Start the current release's app, now and at each boot of the robot. Return `read_status`'s status.

    If a new release still has a pending health check, the start does not restart the check.
    """
    if releases.read_current(layout) is None:
        raise AgentError("there is no release to start", "Send one: robotcore deploy push", "no-current-release")
    with hold_lock(layout, "start of the app"):
        units.install_service(layout)
        pending = health_check.read_pending(layout)
        systemd.start(HEALTH_CHECK if pending else SERVICE)
    if pending:
        follow_check(layout, pending)
    wait_until_settled()
    return read_status(layout)


def stop_app(layout: Layout) -> dict[str, Any]:
    """Stop the app, and do not start it at the next boot. Return `read_status`'s status.

    The app stops before the function waits for the lock. If a health check is running, it ends: the previous release
    becomes the current one, and its app is not started.
    """
    if list_installed_units(layout):
        systemd.stop(SERVICE, HEALTH_CHECK)
        systemd.stop(SERVICE)  # again, because the health check may have restarted the app meanwhile
        systemd.systemctl("disable", SERVICE)
        health_check.abandon_check(layout)
    return read_status(layout)


def read_status(layout: Layout) -> dict[str, Any]:
    """Return the state of the app and of the robot, see `robot_answers.StatusAnswer`."""
    state, name, pending = systemd.read_state(SERVICE), releases.read_current(layout), health_check.read_pending(layout)
    state_name = _name_state(state)
    reason, lines = _explain_failure(state)
    sizes = [size for file in layout.recordings.glob("*.mcap") if (size := measure_recording(file))]
    return {
        "release": name,
        "outcome": read_outcome(layout, name),
        "pending": pending.release if pending else None,
        "last": None if name else _read_last_check(layout),
        "state": state_name,
        "for_s": time.monotonic() - state.active_since_s if state.is_up else None,
        "restarts": state.restarts,
        "status_text": "" if state_name == "stopped" else state.status_text,  # the text may be another release's
        "view_port": _read_view_port(layout, name),
        "reason": reason,
        "lines": lines,
        "starts_with_robot": state.is_enabled,
        "lingers": robot_facts.is_lingering(),
        "recordings": {"files": len(sizes), "bytes": sum(sizes)},
        "free_bytes": measure_free_space(layout.home),
    }


def _read_view_port(layout: Layout, name: str | None) -> int | None:
    with suppress(OSError, ValueError):  # no release, or its manifest is damaged
        return Release.read(layout.releases / name).view_port if name else None
    return None


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
        reason, invocation = state.describe_end(), state.invocation
    elif state.restarts and (end := journal.read_last_end(SERVICE)):
        reason, invocation = end
    else:
        return "", []
    return reason, list(journal.read_last_lines(SERVICE, invocation))


def _read_last_check(layout: Layout) -> dict[str, str] | None:
    for name in releases.list_names(layout):
        if result := HealthResult.read(layout.releases / name):
            return {"name": name, "outcome": result.outcome, "reason": result.reason}
    return None


def print_log(layout: Layout, *, lines: int = 50, follow: bool = False) -> dict[str, Any]:  # noqa: ARG001  every action takes it
    """Print the last lines of the app's output as plain text. With ``follow``, print new lines too.

    lines: the number of lines.
    """
    journal.print_lines(SERVICE, lines, is_followed=follow)
    return {}
