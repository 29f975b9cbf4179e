"""A folder at the desk that is as a release's folder is to be on the robot."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from robotcore.deploy.aboard.release import PROJECT, SITE
from robotcore.deploy.files import Listing, listed
from robotcore.deploy.paths import told
from robotcore.deploy.project import Project
from robotcore.deploy.requirements import requirements_of
from robotcore.deploy.site import build_site
from robotcore.errors import UsageError

MAX_TOLD = 5
"""So many files are named in a message."""


@dataclass(frozen=True)
class Staged:
    """What is in the folder that is to be sent.

    ``project`` is the user's files, times kept, so that rsync sees which have changed; ``site`` is robotcore and what
    else is brought; ``requirements`` are what pip installs there. ``left_out`` are the secrets that stay at home, by
    their names in the project.
    """

    folder: Path
    requirements: tuple[str, ...]
    left_out: tuple[str, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """What was left out, for whoever sends it."""
        if not self.left_out:
            return ()
        return (f"left out, for there may be secrets in it: {_names(self.left_out)}",)


def stage(project: Project, folder: Path) -> Staged:
    """Put into an empty folder what is sent, but for the manifest, which `Release.write` adds.

    Raises UsageError with all links that lead out of the project or nowhere, for a file that the project names and
    that is not sent, and for code that is compiled for this machine; DeployError where the project cannot be built.
    """
    (folder / PROJECT).mkdir()
    listing = _copied(project, folder / PROJECT) if project.folder else Listing(())
    site = build_site(project, folder / PROJECT, folder / SITE)
    return Staged(folder, requirements_of(project, site), listing.secrets)


def _copied(project: Project, target: Path) -> Listing:
    assert project.folder, "who copies has one"
    listing = listed(project.folder)
    _require(project, listing)
    links = dict(_links(project.folder, listing.names))
    for name in listing.names:
        place = target / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if name in links:
            place.symlink_to(links[name])
        else:
            _copy(project.folder / name, place)
    return listing


def _copy(file: Path, place: Path) -> None:
    """Copy a file with its times; what is no file (a socket, a pipe) is nobody's to send."""
    if not file.is_file():
        return
    try:
        shutil.copy2(file, place)
    except OSError as error:
        raise UsageError(f"{told(file)}: {error.strerror}. Let it be read, or let git ignore it") from error


def _require(project: Project, listing: Listing) -> None:
    """Refuse a project that would lack on the robot what it names itself."""
    assert project.folder, "who has files has a folder"
    sent = {os.path.normpath(name) for name in listing.names}
    for name in project.files:
        if os.path.normpath(name) not in sent:
            why = "may hold a secret" if name in listing.secrets else "is ignored by git"
            raise UsageError(f"{told(name)} {why}, so it is not sent, and the project does not run without it")


def _links(folder: Path, names: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield the links among the names and where they lead, from beside them; refuse those that lead to nothing sent."""
    sent = {Path(name) for name in names}
    sent |= {parent for path in sent for parent in path.parents}
    wrong = []
    for name in names:
        if not (link := folder / name).is_symlink():
            continue
        leads = Path(os.path.realpath(link))
        if leads.exists() and leads.is_relative_to(folder) and leads.relative_to(folder) in sent:
            yield name, os.path.relpath(leads, os.path.realpath(link.parent))
        else:
            wrong.append(f"{name} -> {link.readlink()}")
    if wrong:
        raise UsageError(
            f"{_names(wrong)}: such a link leads to nothing that is sent. Put the file itself there, or let git ignore "
            "the link"
        )


def _names(names: Collection[str]) -> str:
    more = f" and {len(names) - MAX_TOLD} more" if len(names) > MAX_TOLD else ""
    return f"{', '.join(map(told, list(names)[:MAX_TOLD]))}{more}"
