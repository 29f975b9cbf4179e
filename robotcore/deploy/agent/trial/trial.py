"""A release on trial: started in another's place, watched, and either kept or taken back.

What is on trial is written down before anything changes, and each step may be done twice: whoever is killed in the
middle, or loses power, is followed by somebody who begins anew.
"""

from __future__ import annotations

import json
import time
from contextlib import suppress
from dataclasses import asdict, dataclass, replace

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.release import require_name
from robotcore.deploy.agent.releases.verdict import HEALTHY, STOPPED, UNHEALTHY, Verdict
from robotcore.deploy.agent.service import systemd
from robotcore.deploy.agent.service.units import SERVICE, TRIAL
from robotcore.deploy.agent.system import durable
from robotcore.deploy.agent.system.locking import locked
from robotcore.deploy.agent.telling import RefusalError
from robotcore.deploy.agent.trial.watching import Seen, watch

HEALTHY_WITHIN_S, SETTLE_S = 60.0, 4.0
"""How long an app has until its first step, and how long it then has to live."""


@dataclass(frozen=True)
class Trial:
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
        durable.write(layout.trial, json.dumps(asdict(self), indent=2) + "\n")
        try:
            systemd.start(TRIAL)
        except BaseException:
            layout.trial.unlink()
            raise

    def verdict(self, layout: Layout) -> Verdict | None:
        """Return what came out of it; None where that is not known yet."""
        verdict = Verdict.read(layout.releases / self.release)
        return verdict if verdict and verdict.since == self.since else None


def pending(layout: Layout) -> Trial | None:
    """Return what is on trial, if something is."""
    try:
        told = json.loads(layout.trial.read_text(encoding="utf-8"))
        require_name(told["release"])
        return Trial(**told)
    except (OSError, ValueError, TypeError, KeyError):
        return None


def now() -> str:
    """Return the moment as a trial names it."""
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())


def conduct(layout: Layout) -> None:
    """Judge what is on trial, to the end; nothing is done where nothing is."""
    with locked(layout, "a release is on trial"):
        if trial := pending(layout):
            verdict = trial.verdict(layout) or _judge(layout, trial)
            _conclude(layout, trial, verdict)


def abandon(layout: Layout) -> None:
    """End a trial, once the service is down: nothing is started, and what is not known to be healthy is taken back."""
    with locked(layout, "a trial is ended"):
        if trial := pending(layout):
            stopped = Verdict(STOPPED, "somebody stopped it", since=trial.since)
            _conclude(layout, replace(trial, was_standing=True, was_enabled=False), trial.verdict(layout) or stopped)


def _judge(layout: Layout, trial: Trial) -> Verdict:
    """Let the release run; return and write down how it did."""
    if not (layout.releases / trial.release).is_dir():
        return Verdict(UNHEALTHY, "it is no longer there", since=trial.since)
    current.swap(layout, trial.release)
    seen = _seen(trial)
    verdict = Verdict(seen.outcome, seen.reason, seen.lines, trial.since)
    _note(layout, trial, verdict)
    return verdict


def _seen(trial: Trial) -> Seen:
    try:
        return watch(trial.healthy_within_s, trial.settle_s)
    except RefusalError as refusal:
        if refusal.kind == systemd.GONE:
            raise
        return Seen(UNHEALTHY, refusal.fault)


def _note(layout: Layout, trial: Trial, verdict: Verdict) -> None:
    """Write a verdict down, unless the disk is full: that must not keep a bad release running."""
    with suppress(OSError):
        verdict.write(layout.releases / trial.release)


def _conclude(layout: Layout, trial: Trial, verdict: Verdict) -> None:
    """Do what a verdict asks for, and put the trial away."""
    if verdict.outcome == STOPPED:
        _note(layout, trial, verdict)
    if verdict.outcome != HEALTHY:
        _go_back(layout, trial, is_to_run=verdict.outcome == UNHEALTHY)
    layout.trial.unlink(missing_ok=True)
    durable.settle(layout.root)


def _go_back(layout: Layout, trial: Trial, *, is_to_run: bool) -> None:
    """Make the previous release the current one, and run it; where none ran, no wheel turns: none is started.

    Where the disk has no room for a link, nothing runs: the bad release is stopped, and not found again.
    """
    systemd.stop(SERVICE)
    current.swap(layout, None)
    current.swap(layout, trial.previous)
    if trial.previous is None or not trial.was_enabled:
        systemd.disable(SERVICE)
    if trial.previous is not None and is_to_run and not trial.was_standing:
        systemd.restart(SERVICE)
