"""A folder at the desk that is as a release's folder is to be on the robot."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.agent.releases import PROJECT, SITE
from robotcore.deploy.packages.requirements import requirements_of
from robotcore.deploy.packages.site import fill
from robotcore.deploy.paths import list_names
from robotcore.deploy.project import Project
from robotcore.deploy.staging.copying import copied
from robotcore.deploy.staging.files import Listing
from robotcore.errors import UsageError
from robotcore.text import escape

_IGNORED = ("is ignored by git", "Take it out of .gitignore")


MOST_SECRETS = 50
"""So many files that are left out are named: an app may miss each of them."""


@dataclass(frozen=True)
class Staged:
    """A project, and the folder that is to be sent: the user's files in ``project``, what they import in ``site``.

    ``requirements`` are what pip installs there; ``notes`` are what whoever sends it should know.
    """

    project: Project
    folder: Path
    requirements: tuple[str, ...]
    notes: tuple[str, ...] = ()


def stage(project: Project, folder: Path) -> Staged:
    """Put into an empty folder what is sent, but for the manifest, which `Release.write` adds.

    Raises UsageError where a link leads out of the project or nowhere, where a file that the project names would not be
    sent, and for code that is compiled for this machine; DeployError where the project cannot be built.
    """
    listing = _with_files(project, folder / PROJECT)
    pinned, secrets = fill(project, folder / PROJECT, folder / SITE)
    return Staged(
        project, folder, requirements_of(project, folder / SITE, pinned), _notes((*listing.secrets, *secrets))
    )


def _with_files(project: Project, target: Path) -> Listing:
    target.mkdir()
    if project.folder is None:
        return Listing(())
    listing = copied(project.folder, target)
    for name in map(os.path.normpath, project.files):
        if name not in listing.names:
            why, remedy = ("may hold a secret", "Rename it") if name in listing.secrets else _IGNORED
            raise UsageError(f"{escape(name)} {why}, so it is not sent; without it the project does not run. {remedy}")
    return listing


def _notes(secrets: Sequence[str]) -> tuple[str, ...]:
    if not secrets:
        return ()
    return (f"left out because they may hold a secret: {list_names(secrets, MOST_SECRETS)}",)
