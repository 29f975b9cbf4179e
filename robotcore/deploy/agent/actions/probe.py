"""What this robot is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from robotcore.deploy.agent.environment import environments
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.system import needs
from robotcore.deploy.agent.system.facts import facts


def act(layout: Layout, *, requirements: Sequence[str] = (), is_push: bool = False) -> dict[str, Any]:
    """Return the facts, the current ``release``, and whether requirements have an environment (``has_environment``).

    For a push, a robot that cannot take one is refused, with what to do.
    """
    told = {**facts(layout), "release": current.name_of(layout)}
    told["has_environment"] = environments.find(layout, environments.Recipe.of(requirements)) is not None
    if is_push:
        needs.require(told, has_environment=told["has_environment"])
        told.update(is_lingering=True, has_user_manager=True)
    return told
