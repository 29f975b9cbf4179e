"""Tells how the robot does."""

from __future__ import annotations

import time
from typing import Any

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.verdict import Verdict
from robotcore.deploy.agent.service import journal, systemd
from robotcore.deploy.agent.service.systemd import State
from robotcore.deploy.agent.service.units import SERVICE
from robotcore.deploy.agent.system import facts
from robotcore.deploy.agent.system.disk import free_bytes
from robotcore.deploy.agent.trial import trial


def act(layout: Layout) -> dict[str, Any]:
    """Return what runs, and how.

    ``state`` is running, starting, stopping, restarting, ended, failed or stopped; ``for_s`` how long it has been
    running, None where it is not; ``words`` what the app last said of itself, unless it is stopped. ``reason`` and
    ``lines`` tell of a failure, the last one where it was started again after it. ``on_trial`` names the release on
    trial. Where no release is in place, ``last`` is the newest that was tried, by its ``name``, with ``outcome`` and
    ``reason``.
    """
    state, name, tried = systemd.show(SERVICE), current.name_of(layout), trial.pending(layout)
    word = _word(state)
    reason, lines = _failure(state)
    return {
        "release": name,
        "verdict": _verdict(layout, name),
        "on_trial": tried.release if tried else None,
        "last": None if name else _last(layout),
        "state": word,
        "for_s": time.monotonic() - state.active_since_s if state.is_up else None,
        "restarts": state.restarts,
        "words": "" if word == "stopped" else state.words,  # of whichever release ran last
        "reason": reason,
        "lines": lines,
        "starts_with_robot": state.is_enabled,
        "lingers": facts.is_lingering(),
        "recordings": _recordings(layout),
        "free_bytes": free_bytes(layout.home),
    }


def _word(state: State) -> str:
    if state.sub == "auto-restart":
        return "restarting"
    if state.has_failed:
        return "failed"
    if state.has_succeeded and state.invocation:
        return "ended"
    return {"active": "running", "activating": "starting", "deactivating": "stopping"}.get(state.active, "stopped")


def _failure(state: State) -> tuple[str, list[str]]:
    if state.has_failed:
        reason, invocation = state.ending(), state.invocation
    elif state.restarts and (ended := journal.last_end(SERVICE)):
        reason, invocation = ended
    else:
        return "", []
    return reason, list(journal.last_lines(SERVICE, invocation))


def _verdict(layout: Layout, name: str | None) -> str | None:
    verdict = Verdict.read(layout.releases / name) if name else None
    return verdict.outcome if verdict else None


def _last(layout: Layout) -> dict[str, str] | None:
    for name in current.names(layout):
        if verdict := Verdict.read(layout.releases / name):
            return {"name": name, "outcome": verdict.outcome, "reason": verdict.reason}
    return None


def _recordings(layout: Layout) -> dict[str, int]:
    sizes = [size for file in layout.recordings.glob("*.mcap") if (size := file.stat().st_size)]
    return {"files": len(sizes), "bytes": sum(sizes)}
