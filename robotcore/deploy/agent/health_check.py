"""Check the health of a new release: start it in place of the current one, watch it, and keep it or roll back.

The check is written to disk before anything changes, and each step may be repeated. If the process is killed or the
power fails, systemd starts the check again.
"""

from __future__ import annotations

import json
import time
from contextlib import suppress
from dataclasses import asdict, dataclass, replace

from robotcore.deploy.agent import files, journal, releases, systemd
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.lock import hold_lock
from robotcore.deploy.agent.releases import HEALTHY, STOPPED, UNHEALTHY, HealthResult, require_name
from robotcore.deploy.agent.rpc import AgentError
from robotcore.deploy.agent.systemd import UnitState
from robotcore.deploy.agent.units import HEALTH_CHECK, SERVICE

HEALTHY_WITHIN_S, SETTLE_S = 60.0, 4.0
"""How long an app has until its first step, and how long it then has to live."""


@dataclass(frozen=True)
class HealthCheck:
    """What is on trial: a release, the ``previous`` one that is there again if it is not healthy, and how it is judged.

    ``since`` is in UTC, and tells this trial from another one of the same release. The previous one is found again as
    it was: where nothing ran (``was_standing``) nothing is started, and it starts with the robot where it did
    (``was_enabled``).
    """

    release: str
    previous: str | None
    healthy_within_s: float = HEALTHY_WITHIN_S
    settle_s: float = SETTLE_S
    since: str = ""
    was_standing: bool = False
    was_enabled: bool = True

    def begin(self, layout: Layout) -> None:
        """Write it down, and let systemd have it judged: from now on it will be, whatever happens.

        The caller holds the lock. Raises OSError or RefusalError, and then nothing is on trial.
        """
        files.write_file(layout.trial, json.dumps(asdict(self), indent=2) + "\n")
        try:
            systemd.start(HEALTH_CHECK)
        except BaseException:
            layout.trial.unlink()
            raise

    def verdict(self, layout: Layout) -> HealthResult | None:
        """Return what came out of it; None where that is not known yet."""
        verdict = HealthResult.read(layout.releases / self.release)
        return verdict if verdict and verdict.since == self.since else None


def read_pending(layout: Layout) -> HealthCheck | None:
    """Return what is on trial, if something is."""
    try:
        told = json.loads(layout.trial.read_text(encoding="utf-8"))
        require_name(told["release"])
        return HealthCheck(**told)
    except (OSError, ValueError, TypeError, KeyError):
        return None


def format_now() -> str:
    """Return the moment as a trial names it."""
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())


def run_check(layout: Layout) -> None:
    """Judge what is on trial, to the end; nothing is done where nothing is."""
    with hold_lock(layout, "a release is on trial"):
        if trial := read_pending(layout):
            verdict = trial.verdict(layout) or _check_release(layout, trial)
            _conclude(layout, trial, verdict)


def abandon_check(layout: Layout) -> None:
    """End a trial, once the service is down: nothing is started, and what is not known to be healthy is taken back."""
    with hold_lock(layout, "a trial is ended"):
        if trial := read_pending(layout):
            stopped = HealthResult(STOPPED, "somebody stopped it", since=trial.since)
            _conclude(layout, replace(trial, was_standing=True, was_enabled=False), trial.verdict(layout) or stopped)


def _check_release(layout: Layout, trial: HealthCheck) -> HealthResult:
    """Let the release run; return and write down how it did."""
    if not (layout.releases / trial.release).is_dir():
        return HealthResult(UNHEALTHY, "it is no longer there", since=trial.since)
    releases.set_current(layout, trial.release)
    seen = _watch_release(trial)
    verdict = HealthResult(seen.outcome, seen.reason, seen.lines, trial.since)
    _write_result(layout, trial, verdict)
    return verdict


def _watch_release(trial: HealthCheck) -> Seen:
    try:
        return watch_app(trial.healthy_within_s, trial.settle_s)
    except AgentError as refusal:
        if refusal.kind == systemd.MANAGER_GONE:
            raise
        return Seen(UNHEALTHY, refusal.fault)


def _write_result(layout: Layout, trial: HealthCheck, verdict: HealthResult) -> None:
    """Write a verdict down, unless the disk is full: that must not keep a bad release running."""
    with suppress(OSError):
        verdict.write(layout.releases / trial.release)


def _conclude(layout: Layout, trial: HealthCheck, verdict: HealthResult) -> None:
    """Do what a verdict asks for, and put the trial away."""
    if verdict.outcome == STOPPED:
        _write_result(layout, trial, verdict)
    if verdict.outcome != HEALTHY:
        _roll_back(layout, trial, is_to_run=verdict.outcome == UNHEALTHY)
    layout.trial.unlink(missing_ok=True)
    files.sync_folder(layout.root)


def _roll_back(layout: Layout, trial: HealthCheck, *, is_to_run: bool) -> None:
    """Make the previous release the current one, and run it; where none ran, no wheel turns: none is started.

    Where the disk has no room for a link, nothing runs: the bad release is stopped, and not found again.
    """
    systemd.stop(SERVICE)
    releases.set_current(layout, None)
    releases.set_current(layout, trial.previous)
    if trial.previous is None or not trial.was_enabled:
        systemd.disable(SERVICE)
    if trial.previous is not None and is_to_run and not trial.was_standing:
        systemd.restart(SERVICE)


POLL_S = 0.25
"""Far shorter than the units' RestartSec: no start of a failing app is missed."""

STOP_LIMIT_S = 90.0
"""For the release that ran before to stop, by the times of its unit: the app, then what stops its motors."""

NO_WATCHDOG_S = 30.0
"""Far longer than the unit's WatchdogSec: what is up so long without a word has no watchdog, by somebody's wish."""


@dataclass(frozen=True)
class Seen:
    """What somebody saw who watched: the verdict's outcome, why, and what the app wrote last."""

    outcome: str
    reason: str = ""
    lines: tuple[str, ...] = ()


def watch_app(healthy_within_s: float, settle_s: float) -> Seen:
    """Restart the service, and return how it did: it has to come up in time, and then to stay for ``settle_s``.

    After that it has to tell systemd's watchdog once more that its loop is alive: what hangs is up too, until somebody
    notices. An app that ends with success has done all that it was to do. Raises RefusalError where systemd does not
    answer, and `ShutdownError` where the robot goes down meanwhile.
    """
    seen = _watch(healthy_within_s, settle_s)
    if seen.outcome != HEALTHY and systemd.is_shutting_down():
        raise ShutdownError("the robot goes down; the trial begins anew when it is up")
    return seen


class ShutdownError(Exception):
    """The robot goes down: what is seen now tells nothing of the release."""


def _watch(healthy_within_s: float, settle_s: float) -> Seen:
    state = _wait_for_start(systemd.restart(SERVICE))
    if state is None:
        return Seen(UNHEALTHY, "systemd did not start it")
    ours, started, up_since = state.invocation, time.monotonic(), None
    while (seen := _judge_state(state, ours)) is None:
        now = time.monotonic()
        up_since = up_since or (now if state.is_up else None)
        if state.is_up and up_since and _has_settled(state, up_since + settle_s, now):
            return Seen(HEALTHY)
        if state.active == "activating" and now - started >= healthy_within_s:
            return _build_unhealthy(_explain_not_ready(healthy_within_s), ours)
        time.sleep(POLL_S)
        state = systemd.read_state(SERVICE)
        if state.invocation != ours and not state.restarts:  # by hand: it is watched anew
            ours, started, up_since = state.invocation, time.monotonic(), None
    return seen


def _has_settled(state: UnitState, until: float, now: float) -> bool:
    return now >= until and (state.alive_at_s >= until or now >= until + NO_WATCHDOG_S)


def _wait_for_start(before: str) -> UnitState | None:
    """Return the service's state once it was started anew, by somebody; None where it was not.

    What failed before may be started by systemd once more until it hears of us: that start is not ours.
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


def _judge_state(state: UnitState, ours: str) -> Seen | None:
    """Return what a state tells, seen while the service was started as ``ours``; None where it tells nothing yet.

    A failure is told once the process has ended: how, and what it wrote at last, is not known before.
    """
    if state.has_failed and state.active == "deactivating":
        return None
    if state.has_failed or state.restarts:
        return _build_unhealthy(state.ending() if state.has_failed else "it was started again", ours)
    if state.has_succeeded:
        return Seen(HEALTHY, "it ended with success")
    if state.is_down and not state.has_job:
        return Seen(STOPPED, "somebody stopped it")
    return None


def _explain_not_ready(healthy_within_s: float) -> str:
    more = "if it is only slow, push it with a longer --healthy-within"
    return f"its first step had not come back within {healthy_within_s:g} s; {more}"


def _build_unhealthy(reason: str, invocation: str) -> Seen:
    return Seen(UNHEALTHY, reason, journal.read_last_lines(SERVICE, invocation))
