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

ABANDONED_S = 45.0
"""Whoever stops a trial, and then the app, puts it away within this time."""


def follow_check(layout: Layout, trial: HealthCheck) -> dict[str, Any]:
    """Report the progress of a health check; return its result as `build_report` does.

    Raises AgentError if no process runs the check.
    """
    phase, conducted = "", time.monotonic()
    while read_pending(layout) == trial:
        if (words := _describe_phase(trial)) not in {phase, ""}:
            phase = words
            report_progress(words)
        if _is_check_running():
            conducted = time.monotonic()
        elif time.monotonic() - conducted > ABANDONED_S:
            raise AgentError(
                f"the health check of {trial.release} is not running",
                "Resume it: robotcore deploy start",
                "check-stopped",
                release=trial.release,
            )
        time.sleep(POLL_S)
    unknown = HealthResult(STOPPED, "another release took its place, or nothing could be written down")
    return build_report(layout, trial.release, trial.verdict(layout) or unknown)


def build_report(layout: Layout, release: str, verdict: HealthResult) -> dict[str, Any]:
    """Return what came of a release's trial.

    ``outcome``, ``reason`` and ``lines`` are the verdict's; ``current`` is the release that is in place now, None where
    none is, ``is_running`` whether it runs, and ``is_standing`` whether nothing has started it: the previous one is
    waited for.
    """
    name = releases.read_current(layout)
    is_back = name is not None and verdict.outcome == UNHEALTHY
    state = wait_until_settled(f"{name} runs again" if is_back else "")
    return {
        "release": release,
        "outcome": verdict.outcome,
        "reason": verdict.reason,
        "lines": list(verdict.lines),
        "current": name,
        "is_running": state.is_up,
        "is_standing": state.is_down,
    }


def wait_until_settled(words: str = "") -> UnitState:
    """Return the service's state once it is neither starting nor stopping; say so where it is up."""
    until = time.monotonic() + START_LIMIT_S
    while (state := systemd.read_state(SERVICE)).is_between and time.monotonic() < until:
        time.sleep(POLL_S)
    if words and state.is_up:
        report_progress(words)
    return state


def _describe_phase(trial: HealthCheck) -> str:
    """Return how far a release is; empty as long as it is not the one that runs."""
    if releases.read_running() != trial.release:
        return ""
    if systemd.read_state(SERVICE).is_up:
        return f"it is ready; whether it stays so is seen for {trial.settle_s:g} s"
    return "it starts"


def _is_check_running() -> bool:
    """Return whether somebody conducts the trial, or is about to; raises RefusalError where that failed for good."""
    state = systemd.read_state(HEALTH_CHECK)
    if state.active == "failed":
        words = " / ".join(journal.read_last_lines(HEALTH_CHECK, state.invocation)) or state.ending()
        raise AgentError(
            f"the health check of the release failed: {words}",
            "Look at it there: systemctl --user status robotcore-trial",
            "check-failed",
        )
    return state.has_job or not state.is_down
