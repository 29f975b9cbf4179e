"""What was sent becomes a release; none that is there is touched."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from robotcore.deploy.agent.environment import environments, pip
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import incoming
from robotcore.deploy.agent.releases.release import ENVIRONMENT, PROJECT, SITE, WHEELS, Release, require_name
from robotcore.deploy.agent.service import doctoring
from robotcore.deploy.agent.system import durable
from robotcore.deploy.agent.system.locking import locked
from robotcore.deploy.agent.telling import RefusalError, say


def act(layout: Layout, *, release: str, is_offline: bool = False) -> dict[str, Any]:
    """Give a release that was sent whole its environment, let its doctor look at the robot, and put it with the others.

    Returns whether the ``environment`` was ``kept`` or ``made``, and the doctor's ``findings``.
    """
    folder = layout.incoming / require_name(release)
    with locked(layout, f"installation of {release}") as handle:
        told = _sent(folder, release)
        need = pip.Need(folder / WHEELS if is_offline else None, folder / SITE, (handle,))
        environment, how = _environment(layout, told, need)
        incoming.erase(folder / WHEELS)
        durable.link(folder / ENVIRONMENT, f"../../environments/{environment.name}")
        say("doctor looks at the robot")
        findings = doctoring.findings_of(folder, told)
        os.sync()
        durable.move(folder, layout.releases / release)
        incoming.forget(layout, release)
    return {"release": release, "environment": how, "findings": findings}


def _sent(folder: Path, release: str) -> Release:
    try:
        told = Release.read(folder)
        is_whole = told.name == release and all(folder.joinpath(part).is_dir() for part in (PROJECT, SITE))
    except (OSError, ValueError, KeyError, TypeError):
        is_whole = False
    if not is_whole:
        raise RefusalError(f"{release} was not sent whole", "Push again", "incomplete")
    return told


def _environment(layout: Layout, release: Release, need: pip.Need) -> tuple[Path, str]:
    recipe = environments.Recipe.of(release.requirements)
    if there := environments.find(layout, recipe):
        return there, "kept"
    say("making an environment")
    return environments.make(layout, recipe, release.name, need, say), "made"
