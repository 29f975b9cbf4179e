"""Report the progress of a health check. Read-only: interrupting it does not affect the release."""

from __future__ import annotations

import time
from typing import Any

from robotcore.deploy.agent import journal, releases, systemd
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.health_check import HealthCheck, read_pending
from robotcore.deploy.agent.releases import STOPPED, UNHEALTHY, HealthResult
from robotcore.deploy.agent.rpc import AgentError, report_progress
from robotcore.deploy.agent.systemd import UnitState
from robotcore.deploy.agent.units import HEALTH_CHECK, SERVICE, START_LIMIT_S

POLL_S = 0.3
"""The time between two looks at the check, in s."""

ABANDONED_S = 45.0
"""A process that ends a check, and the app after it, deletes the check within this time."""


def follow_check(layout: Layout, check: HealthCheck) -> dict[str, Any]:
    """Report the progress of a health check; return its result as `build_report` does.

    Raises AgentError if no process runs the check.
    """
    phase, running_at = "", time.monotonic()
    while read_pending(layout) == check:
        if (words := _describe_phase(check)) not in {phase, ""}:
            phase = words
            report_progress(words)
        if _is_check_running():
            running_at = time.monotonic()
        elif time.monotonic() - running_at > ABANDONED_S:
            raise AgentError(
                f"the health check of {check.release} is not running",
                "Resume it: robotcore deploy start",
                "check-stopped",
                release=check.release,
            )
        time.sleep(POLL_S)
    unknown = HealthResult(STOPPED, "another release replaced it, or the result could not be stored")
    return build_report(layout, check.release, check.read_result(layout) or unknown)


def build_report(layout: Layout, release: str, result: HealthResult) -> dict[str, Any]:
    """Return the result of a release's health check as the desk expects it.

    ``outcome``, ``reason`` and ``lines`` are the result's. ``current`` is the current release or None, ``is_running``
    whether it runs, ``is_standing`` whether it is stopped. If the previous release starts again, its start is awaited.
    """
    name = releases.read_current(layout)
    is_back = name is not None and result.outcome == UNHEALTHY
    state = wait_until_settled(f"{name} runs again" if is_back else "")
    return {
        "release": release,
        "outcome": result.outcome,
        "reason": result.reason,
        "lines": list(result.lines),
        "current": name,
        "is_running": state.is_up,
        "is_standing": state.is_down,
    }


def wait_until_settled(words: str = "") -> UnitState:
    """Return the service's state once it is neither starting nor stopping.

    words: what to report if it is up then; empty for no report.
    """
    until = time.monotonic() + START_LIMIT_S
    while (state := systemd.read_state(SERVICE)).is_changing and time.monotonic() < until:
        time.sleep(POLL_S)
    if words and state.is_up:
        report_progress(words)
    return state


def _describe_phase(check: HealthCheck) -> str:
    """Return the progress of the release that is checked; empty while another one runs."""
    if releases.read_running() != check.release:
        return ""
    if systemd.read_state(SERVICE).is_up:
        return f"it is ready; whether it stays so is seen for {check.settle_s:g} s"
    return "it starts"


def _is_check_running() -> bool:
    """Return whether the check's unit runs or is about to start; raises AgentError if it has failed for good."""
    state = systemd.read_state(HEALTH_CHECK)
    if state.active == "failed":
        words = " / ".join(journal.read_last_lines(HEALTH_CHECK, state.invocation)) or state.describe_end()
        raise AgentError(
            f"the health check of the release failed: {words}",
            "Look at it there: systemctl --user status robotcore-trial",
            "check-failed",
        )
    return state.has_job or not state.is_down
