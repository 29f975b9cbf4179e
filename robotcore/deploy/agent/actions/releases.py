"""Which releases there are."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.release import Release
from robotcore.deploy.agent.releases.verdict import Verdict
from robotcore.deploy.agent.trial import trial


def act(layout: Layout) -> dict[str, Any]:
    """Return the ``releases``, the newest first, which is ``current``, and which is ``on_trial``.

    Each is as its file tells of it, with the ``verdict`` of its last trial, None where it had none, and its ``reason``;
    one whose file cannot be read has its ``name`` and why it is ``unreadable``.
    """
    tried = trial.pending(layout)
    return {
        "releases": [_told(layout, name) for name in current.names(layout)],
        "current": current.name_of(layout),
        "on_trial": tried.release if tried else None,
    }


def _told(layout: Layout, name: str) -> dict[str, Any]:
    folder = layout.releases / name
    try:
        told = asdict(Release.read(folder))
    except (OSError, ValueError, KeyError, TypeError) as error:
        told = {"name": name, "unreadable": str(error)}
    verdict = Verdict.read(folder)
    return {**told, "verdict": verdict.outcome if verdict else None, "reason": verdict.reason if verdict else ""}
