"""The health check of a new release: start it in place of the current one, watch its app, and keep it or roll back.

The check is stored on disk before anything changes, and each of its steps is idempotent. So systemd can start the check
again after its process was killed or the power failed.
"""

from __future__ import annotations

import json
import time
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import Any

from robotcore.deploy.agent import files, journal, releases, robot_facts
from robotcore.deploy.agent import systemctl as systemd
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout, hold_lock
from robotcore.deploy.agent.releases import (
    HEALTHY,
    HEALTHY_WITHIN_S,
    SETTLE_S,
    STOPPED,
    UNHEALTHY,
    HealthResult,
    require_name,
)
from robotcore.deploy.agent.rpc import report_progress
from robotcore.deploy.agent.systemctl import UnitState
from robotcore.deploy.agent.systemd_units import HEALTH_CHECK, SERVICE, START_LIMIT_S

POLL_S = 0.25
"""The time between two queries of the app's state, in s.

It is far shorter than RestartSec of the unit, so that the check detects each restart of a failing app.
"""

STOP_LIMIT_S = 90.0
"""The time limit for the stop of the previous release, in s: the unit's limit for the app plus that for the motors."""

NO_WATCHDOG_S = 30.0
"""The time without a reset of the watchdog, in s, after which a user must have disabled the unit's watchdog.

The time is far longer than WatchdogSec of the unit.
"""


class ShutdownError(Exception):
    """Raised if the robot shuts down during a health check. The check then has no result."""


@dataclass(frozen=True)
class HealthCheck:
    """A health check of a release, as it is stored on the robot."""

    release: str
    """The name of the checked release."""
    previous: str | None
    """The name of the release that a rollback makes current; None without such a release."""
    healthy_within_s: float = HEALTHY_WITHIN_S
    """The time limit for the app's first tick, in s."""
    settle_s: float = SETTLE_S
    """The time that the app must keep running after its first tick, in s."""
    since: str = ""
    """The time in UTC at which the check began. It distinguishes several checks of a release."""
    was_standing: bool = False
    """Whether no app ran before the check. A rollback then starts no app."""
    was_enabled: bool = True
    """Whether systemd started the previous release at each boot of the robot."""

    def begin(self, layout: Layout) -> None:
        """Store the check on disk, and start the systemd unit that runs it. The caller must hold the lock.

        systemd completes the check even after a power failure. After OSError or AgentError, no check is pending.
        """
        files.write_file(layout.health_check, json.dumps(asdict(self), indent=2) + "\n")
        try:
            systemd.start(HEALTH_CHECK)
        except BaseException:
            layout.health_check.unlink()
            raise

    def read_result(self, layout: Layout) -> HealthResult | None:
        """Return the result of this check; None if the check is not complete."""
        result = HealthResult.read(layout.releases / self.release)
        return result if result and result.since == self.since else None


def read_pending(layout: Layout) -> HealthCheck | None:
    """Return the health check that is pending or running; None if there is no such check."""
    try:
        fields = json.loads(layout.health_check.read_text(encoding="utf-8"))
        require_name(fields["release"])
        return HealthCheck(**fields)
    except (OSError, ValueError, TypeError, KeyError):
        return None


def run_check(layout: Layout) -> None:
    """Run the pending health check to its end, and keep the release or roll back. Without a check, do nothing."""
    with hold_lock(layout, "a health check"):
        if check := read_pending(layout):
            result = check.read_result(layout) or _check_release(layout, check)
            _keep_or_roll_back(layout, check, result)


def abandon_check(layout: Layout) -> None:
    """End the pending health check after a user has stopped the app. Roll back unless the release is healthy already.

    This function starts no app.
    """
    with hold_lock(layout, "a health check is ended"):
        if check := read_pending(layout):
            stopped = HealthResult(STOPPED, "a user stopped it", since=check.since)
            _keep_or_roll_back(
                layout, replace(check, was_standing=True, was_enabled=False), check.read_result(layout) or stopped
            )


def watch_app(healthy_within_s: float, settle_s: float) -> HealthResult:
    """Restart the app, watch it, and return the result of the health check without ``since``.

    An app is healthy if it ends with success, or if

    - it completes its first tick within ``healthy_within_s``,
    - it then keeps running for ``settle_s``,
    - and it resets systemd's watchdog after that. systemd calls a hanging app active too.

    Raises AgentError if systemd does not answer, and `ShutdownError` if the robot shuts down.
    """
    try:
        result = _watch(healthy_within_s, settle_s)
    except AgentError as error:
        if error.kind in {systemd.MANAGER_GONE, robot_facts.NO_SYSTEMD.kind}:  # a rollback is not possible either
            raise
        result = HealthResult(UNHEALTHY, error.problem)
    if result.outcome != HEALTHY and systemd.is_shutting_down():
        raise ShutdownError("the robot shuts down; the health check is repeated after the next start")
    return result


def _check_release(layout: Layout, check: HealthCheck) -> HealthResult:
    if not (layout.releases / check.release).is_dir():
        return HealthResult(UNHEALTHY, "the robot no longer has this release", since=check.since)
    releases.set_current(layout, check.release)
    result = replace(watch_app(check.healthy_within_s, check.settle_s), since=check.since)
    _write_result(layout, check, result)
    return result


def _write_result(layout: Layout, check: HealthCheck, result: HealthResult) -> None:
    with suppress(OSError):  # the rollback must follow even on a full disk
        result.write(layout.releases / check.release)


def _keep_or_roll_back(layout: Layout, check: HealthCheck, result: HealthResult) -> None:
    if result.outcome == STOPPED:
        _write_result(layout, check, result)
    if result.outcome != HEALTHY:
        _roll_back(layout, check, starts_app=result.outcome == UNHEALTHY)
    layout.health_check.unlink(missing_ok=True)
    files.sync_folder(layout.root)


def _roll_back(layout: Layout, check: HealthCheck, *, starts_app: bool) -> None:
    """Make the previous release the current one, and start its app if an app ran before the check.

    If the disk has no room for the link to the release, no release is current, and no app runs.
    """
    systemd.stop(SERVICE)
    releases.set_current(layout, None)
    releases.set_current(layout, check.previous)
    if check.previous is None or not check.was_enabled:
        systemd.systemctl("disable", SERVICE)
    if check.previous is not None and starts_app and not check.was_standing:
        systemd.restart(SERVICE)


def _watch(healthy_within_s: float, settle_s: float) -> HealthResult:
    state = _wait_for_start(systemd.restart(SERVICE))
    if state is None:
        return HealthResult(UNHEALTHY, "systemd did not start it")
    ours, started, up_since = state.invocation, time.monotonic(), None
    while (result := _find_result(state, ours)) is None:
        now = time.monotonic()
        up_since = up_since or (now if state.is_up else None)
        if state.is_up and up_since and _has_settled(state, up_since + settle_s, now):
            return HealthResult(HEALTHY)
        if state.active == "activating" and now - started >= healthy_within_s:
            remedy = "if it is only slow, push it with a longer --healthy-within"
            return _build_unhealthy(f"it did not complete its first tick within {healthy_within_s:g} s; {remedy}", ours)
        time.sleep(POLL_S)
        state = systemd.read_state(SERVICE)
        if state.invocation != ours and not state.restarts:  # a user restarted it, so the check begins again
            ours, started, up_since = state.invocation, time.monotonic(), None
    return result


def _has_settled(state: UnitState, until: float, now: float) -> bool:
    return now >= until and (state.alive_at_s >= until or now >= until + NO_WATCHDOG_S)


def _wait_for_start(before: str) -> UnitState | None:
    """Wait until systemd has started the service, and return its state; None if systemd does not start it.

    If the previous release had failed, systemd may restart that release first. Such a start does not count.

    before: the identifier of the invocation before the start.
    """
    until = time.monotonic() + STOP_LIMIT_S
    while time.monotonic() < until:
        state = systemd.read_state(SERVICE)
        is_another_start = state.restarts and state.has_job
        if state.invocation not in {before, ""} and not is_another_start:
            return state
        if state.is_down and not state.has_job:
            return None
        time.sleep(POLL_S)
    return None


def _find_result(state: UnitState, ours: str) -> HealthResult | None:
    """Return the result of the check if the state of the service decides it, else None.

    After a failure, the result has to wait for the end of the process, with its exit status and its last output.

    ours: the identifier of the service's invocation with the checked release.
    """
    if state.has_failed and state.active == "deactivating":
        return None
    if state.has_failed or state.restarts:
        return _build_unhealthy(state.describe_end() if state.has_failed else "it was started again", ours)
    if state.has_succeeded:
        return HealthResult(HEALTHY, "it ended with success")
    if state.is_down and not state.has_job:
        return HealthResult(STOPPED, "a user stopped it")
    return None


def _build_unhealthy(reason: str, invocation: str) -> HealthResult:
    return HealthResult(UNHEALTHY, reason, journal.read_last_lines(SERVICE, invocation))


FOLLOW_POLL_S = 0.3
"""The time between two queries of the health check's state, in s."""

ABANDONED_S = 45.0
"""The time without a process of the health check, in s, after which a pending check counts as abandoned."""


def follow_check(layout: Layout, check: HealthCheck) -> dict[str, Any]:
    """Report the progress of a health check until it ends. Return `build_health_answer`'s report.

    Raises AgentError if no process runs the check.
    """
    phase, running_at = "", time.monotonic()
    while read_pending(layout) == check:
        if (text := _describe_phase(check)) not in {phase, ""}:
            phase = text
            report_progress(text)
        if _is_check_running():
            running_at = time.monotonic()
        elif time.monotonic() - running_at > ABANDONED_S:
            raise AgentError(
                f"the health check of {check.release} is not running",
                "Resume it: robotcore deploy start",
                "check-stopped",
                release=check.release,
            )
        time.sleep(FOLLOW_POLL_S)
    unknown = HealthResult(STOPPED, "another release replaced this one, or the result could not be stored")
    return build_health_answer(layout, check.release, check.read_result(layout) or unknown)


def build_health_answer(layout: Layout, release: str, result: HealthResult) -> dict[str, Any]:
    """Return the answer to the client about a completed health check, see `robot_answers.HealthAnswer`.

    After a rollback, the function first waits until the previous release has started again.
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
        "is_stopped": state.is_down,
    }


def wait_until_settled(text: str = "") -> UnitState:
    """Wait until the service is neither starting nor stopping, and return its state.

    text: the progress text to report if the service runs after the wait; empty for no report.
    """
    until = time.monotonic() + START_LIMIT_S
    while (state := systemd.read_state(SERVICE)).is_changing and time.monotonic() < until:
        time.sleep(FOLLOW_POLL_S)
    if text and state.is_up:
        report_progress(text)
    return state


def _describe_phase(check: HealthCheck) -> str:
    """Return the activity of the checked release in words; empty while another release runs."""
    if releases.read_running() != check.release:
        return ""
    is_up = systemd.read_state(SERVICE).is_up
    return f"it is ready, and must keep running for {check.settle_s:g} s" if is_up else "it starts"


def _is_check_running() -> bool:
    """Return whether the systemd unit of the health check runs or is about to start.

    Raises AgentError if the unit has failed for good.
    """
    state = systemd.read_state(HEALTH_CHECK)
    if state.active == "failed":
        text = " / ".join(journal.read_last_lines(HEALTH_CHECK, state.invocation)) or state.describe_end()
        raise AgentError(
            f"the health check of the release failed: {text}",
            "On the robot: systemctl --user status robotcore-health-check",
            "check-failed",
        )
    return state.has_job or not state.is_down
