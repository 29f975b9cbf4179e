"""Looks on while a release is on trial, and while the one before comes back; whoever stops looking changes nothing."""

from __future__ import annotations

import time
from typing import Any

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.verdict import STOPPED, UNHEALTHY, Verdict
from robotcore.deploy.agent.service import journal, systemd
from robotcore.deploy.agent.service.systemd import State
from robotcore.deploy.agent.service.units import SERVICE, START_LIMIT_S, TRIAL
from robotcore.deploy.agent.telling import RefusalError, say
from robotcore.deploy.agent.trial.trial import Trial, pending

LOOK_S = 0.3

ALONE_S = 45.0
"""Whoever stops a trial, and then the app, puts it away within this time."""


def follow(layout: Layout, trial: Trial) -> dict[str, Any]:
    """Say how a trial goes, and return what came of it: see `told`; raises RefusalError where nobody conducts it."""
    phase, conducted = "", time.monotonic()
    while pending(layout) == trial:
        if (words := _phase(trial)) not in {phase, ""}:
            phase = words
            say(words)
        if _is_conducted():
            conducted = time.monotonic()
        elif time.monotonic() - conducted > ALONE_S:
            raise RefusalError(f"nobody judges {trial.release} any more", "To have it judged: robotcore deploy start")
        time.sleep(LOOK_S)
    unknown = Verdict(STOPPED, "another release took its place, or nothing could be written down")
    return told(layout, trial.release, trial.verdict(layout) or unknown)


def told(layout: Layout, release: str, verdict: Verdict) -> dict[str, Any]:
    """Return what came of a release's trial.

    ``outcome``, ``reason`` and ``lines`` are the verdict's; ``current`` is the release that is in place now, None where
    none is, ``is_running`` whether it runs, and ``is_standing`` whether nothing has started it: the previous one is
    waited for.
    """
    name = current.name_of(layout)
    is_back = name is not None and verdict.outcome == UNHEALTHY
    state = settled(f"{name} runs again" if is_back else "")
    return {
        "release": release,
        "outcome": verdict.outcome,
        "reason": verdict.reason,
        "lines": list(verdict.lines),
        "current": name,
        "is_running": state.is_up,
        "is_standing": state.is_down,
    }


def settled(words: str = "") -> State:
    """Return the service's state once it is neither starting nor stopping; say so where it is up."""
    until = time.monotonic() + START_LIMIT_S
    while (state := systemd.show(SERVICE)).is_between and time.monotonic() < until:
        time.sleep(LOOK_S)
    if words and state.is_up:
        say(words)
    return state


def _phase(trial: Trial) -> str:
    """Return how far a release is; empty as long as it is not the one that runs."""
    if current.running() != trial.release:
        return ""
    if systemd.show(SERVICE).is_up:
        return f"it is ready; whether it stays so is seen for {trial.settle_s:g} s"
    return "it starts"


def _is_conducted() -> bool:
    """Return whether somebody conducts the trial, or is about to; raises RefusalError where that failed for good."""
    state = systemd.show(TRIAL)
    if state.active == "failed":
        words = " / ".join(journal.last_lines(TRIAL, state.invocation)) or state.ending()
        raise RefusalError(
            f"the trial of the release broke off: {words}", "Look at it there: systemctl --user status robotcore-trial"
        )
    return state.has_job or not state.is_down
