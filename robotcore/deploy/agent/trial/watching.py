"""Starts the current release, and looks whether it lives."""

from __future__ import annotations

import time
from dataclasses import dataclass

from robotcore.deploy.agent.releases.verdict import HEALTHY, STOPPED, UNHEALTHY
from robotcore.deploy.agent.service import journal, systemd
from robotcore.deploy.agent.service.systemd import State
from robotcore.deploy.agent.service.units import SERVICE

LOOK_S = 0.25
"""Far shorter than the units' RestartSec: no start of a failing app is missed."""

STOP_LIMIT_S = 90.0
"""For the release that ran before to stop, by the times of its unit: the app, then what stops its motors."""

UNWATCHED_S = 30.0
"""Far longer than the unit's WatchdogSec: what is up so long without a word has no watchdog, by somebody's wish."""


@dataclass(frozen=True)
class Seen:
    """What somebody saw who watched: the verdict's outcome, why, and what the app wrote last."""

    outcome: str
    reason: str = ""
    lines: tuple[str, ...] = ()


def watch(healthy_within_s: float, settle_s: float) -> Seen:
    """Restart the service, and return how it did: it has to come up in time, and then to stay for ``settle_s``.

    After that it has to tell systemd's watchdog once more that its loop is alive: what hangs is up too, until somebody
    notices. An app that ends with success has done all that it was to do. Raises RefusalError where systemd does not
    answer, and `LeavingError` where the robot goes down meanwhile.
    """
    seen = _seen(healthy_within_s, settle_s)
    if seen.outcome != HEALTHY and systemd.is_shutting_down():
        raise LeavingError("the robot goes down; the trial begins anew when it is up")
    return seen


class LeavingError(Exception):
    """The robot goes down: what is seen now tells nothing of the release."""


def _seen(healthy_within_s: float, settle_s: float) -> Seen:
    state = _begun(systemd.restart(SERVICE))
    if state is None:
        return Seen(UNHEALTHY, "systemd did not start it")
    ours, started, up_since = state.invocation, time.monotonic(), None
    while (seen := _judged(state, ours)) is None:
        now = time.monotonic()
        up_since = up_since or (now if state.is_up else None)
        if state.is_up and up_since and _has_settled(state, up_since + settle_s, now):
            return Seen(HEALTHY)
        if state.active == "activating" and now - started >= healthy_within_s:
            return _unhealthy(_not_ready(healthy_within_s), ours)
        time.sleep(LOOK_S)
        state = systemd.show(SERVICE)
        if state.invocation != ours and not state.restarts:  # by hand: it is watched anew
            ours, started, up_since = state.invocation, time.monotonic(), None
    return seen


def _has_settled(state: State, until: float, now: float) -> bool:
    return now >= until and (state.alive_at_s >= until or now >= until + UNWATCHED_S)


def _begun(before: str) -> State | None:
    """Return the service's state once it was started anew, by somebody; None where it was not.

    What failed before may be started by systemd once more until it hears of us: that start is not ours.
    """
    until = time.monotonic() + STOP_LIMIT_S
    while time.monotonic() < until:
        state = systemd.show(SERVICE)
        is_another_start = state.restarts and state.has_job
        if state.invocation not in {before, ""} and not is_another_start:
            return state
        if state.is_down and not state.has_job:
            return None
        time.sleep(LOOK_S)
    return None


def _judged(state: State, ours: str) -> Seen | None:
    """Return what a state tells, seen while the service was started as ``ours``; None where it tells nothing yet.

    A failure is told once the process has ended: how, and what it wrote at last, is not known before.
    """
    if state.has_failed and state.active == "deactivating":
        return None
    if state.has_failed or state.restarts:
        return _unhealthy(state.ending() if state.has_failed else "it was started again", ours)
    if state.has_succeeded:
        return Seen(HEALTHY, "it ended with success")
    if state.is_down and not state.has_job:
        return Seen(STOPPED, "somebody stopped it")
    return None


def _not_ready(healthy_within_s: float) -> str:
    more = "if it is only slow, push it with a longer --healthy-within"
    return f"its first step had not come back within {healthy_within_s:g} s; {more}"


def _unhealthy(reason: str, invocation: str) -> Seen:
    return Seen(UNHEALTHY, reason, journal.last_lines(SERVICE, invocation))
