"""Stops the app, and lets it stand until it is started: a reboot does not start it either."""

from __future__ import annotations

from typing import Any

from robotcore.deploy.agent.actions import status
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.service import systemd
from robotcore.deploy.agent.service.units import SERVICE, TRIAL, installed
from robotcore.deploy.agent.trial import trial


def act(layout: Layout) -> dict[str, Any]:
    """Stop it, whoever else is at work; return the status. Where nothing was put, nothing is done.

    A release that is on trial is not judged any more; the one before is the current one, and stands too.
    """
    if installed(layout):
        systemd.stop(SERVICE, TRIAL)
        systemd.stop(SERVICE)  # which the trial may have started once more
        systemd.disable(SERVICE)
        trial.abandon(layout)
    return status.act(layout)
