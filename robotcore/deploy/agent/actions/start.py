"""Starts the current release, from now on with the robot too."""

from __future__ import annotations

from typing import Any

from robotcore.deploy.agent.actions import status
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.service import systemd, upkeep
from robotcore.deploy.agent.service.units import SERVICE, TRIAL
from robotcore.deploy.agent.system.locking import locked
from robotcore.deploy.agent.telling import RefusalError
from robotcore.deploy.agent.trial import trial
from robotcore.deploy.agent.trial.following import follow, settled


def act(layout: Layout) -> dict[str, Any]:
    """Start it; return the status once it is up, or is not. One whose trial broke off is judged."""
    if current.name_of(layout) is None:
        raise RefusalError("there is no release to start", "Send one: robotcore deploy push")
    with locked(layout, "the app is started"):
        upkeep.ensure(layout)
        tried = trial.pending(layout)
        systemd.start(TRIAL if tried else SERVICE)
    if tried:
        follow(layout, tried)
    settled()
    return status.act(layout)
