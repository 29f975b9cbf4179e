"""Which releases there are."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from robotcore.deploy.aboard import pruning
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.release import Release


def act(layout: Layout) -> dict[str, Any]:
    """Return the ``releases``, the newest first, each as its file tells of it, and which is ``current``."""
    return {"releases": [_told(layout, name) for name in pruning.names(layout)], "current": pruning.current(layout)}


def _told(layout: Layout, name: str) -> dict[str, Any]:
    try:
        return asdict(Release.read(layout.releases / name))
    except (OSError, ValueError, KeyError, TypeError) as error:
        return {"name": name, "unreadable": str(error)}
