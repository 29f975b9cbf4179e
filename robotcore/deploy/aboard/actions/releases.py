"""Which releases there are."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from robotcore.deploy.aboard import pruning
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.release import Release
from robotcore.deploy.aboard.verdict import Verdict


def act(layout: Layout) -> dict[str, Any]:
    """Return the ``releases``, the newest first, and which is ``current``.

    Each is as its file tells of it, and has the outcome of its trial as ``verdict``, None where it had none.
    """
    return {"releases": [_told(layout, name) for name in pruning.names(layout)], "current": pruning.current(layout)}


def _told(layout: Layout, name: str) -> dict[str, Any]:
    folder = layout.releases / name
    verdict = Verdict.read(folder)
    try:
        return {**asdict(Release.read(folder)), "verdict": verdict.outcome if verdict else None}
    except (OSError, ValueError, KeyError, TypeError) as error:
        return {"name": name, "unreadable": str(error)}
