"""A push broke off: what it sent goes."""

from __future__ import annotations

from typing import Any

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import incoming
from robotcore.deploy.agent.releases.release import require_name


def act(layout: Layout, *, release: str) -> dict[str, Any]:
    """Throw away what was sent of a release that was not installed; return whether there was anything."""
    return {"discarded": incoming.forget(layout, require_name(release))}
