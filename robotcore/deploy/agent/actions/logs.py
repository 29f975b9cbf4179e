"""Shows what the app wrote, as the journal has it."""

from __future__ import annotations

from typing import Any

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.service import journal
from robotcore.deploy.agent.service.units import SERVICE


def act(layout: Layout, *, lines: int = 50, follow: bool = False) -> dict[str, Any]:  # noqa: ARG001  as all do
    """Print the last ``lines``, each as it is, without our mark; then, where they are followed, what comes."""
    journal.show(SERVICE, lines, is_followed=follow)
    return {}
