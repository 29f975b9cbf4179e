"""What is brought to the robot as it is installed at the desk: robotcore, and packages of the user's."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from importlib.metadata import Distribution, distribution
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import robotcore
from robotcore.deploy.packages.building import build
from robotcore.deploy.packages.needs import needed
from robotcore.deploy.packages.requirements import ROBOTCORE
from robotcore.deploy.project import Project
from robotcore.errors import DeployError

METADATA = ("METADATA", "entry_points.txt", "top_level.txt")
"""What of a distribution is read where it runs; the rest tells where it is installed here."""

_LEFT = shutil.ignore_patterns("__pycache__", "*.py[co]", ".*")


def fill(project: Project, source: Path, site: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Make ``site``: robotcore, the project's own package, and those of its robot that are installed from this machine.

    ``source`` is what is sent of the project. Return the requirements for those that an index has, and the files
    that are left out because they may hold a secret. Raises DeployError and UsageError as `build` does.
    """
    site.mkdir()
    _bring_robotcore(site)
    if project.folder and project.is_package:
        build(source, site)
    pinned: list[str] = []
    secrets: list[str] = []
    for dist in _others(project):
        place = _origin(dist)
        if isinstance(place, str):
            pinned.append(place)
        elif place != project.folder:
            secrets += build(place, site)
    return tuple(pinned), tuple(secrets)


def _bring_robotcore(site: Path) -> None:
    """Copy its packages, those that its entry points lead to, and its metadata, by which these are found there.

    They are those beside the one that runs: of the same names there may be others in the folder that somebody works in.
    """
    beside = Path(robotcore.__file__).parents[1]
    dist = distribution(ROBOTCORE)
    for package in {ROBOTCORE, *(point.value.partition(".")[0] for point in dist.entry_points)}:
        shutil.copytree(beside / package, site / package, ignore=_LEFT)
    told = site / f"{ROBOTCORE}-{dist.version}.dist-info"
    told.mkdir()
    for name in METADATA:
        if text := dist.read_text(name):
            (told / name).write_text(text, encoding="utf-8")


def _others(project: Project) -> Iterator[Distribution]:
    """Yield the distributions besides robotcore that what the robot runs with comes from."""
    found = {point.dist.name: point.dist for point in needed(project) if point.dist}
    return (dist for name, dist in sorted(found.items()) if name != ROBOTCORE)


def _origin(dist: Distribution) -> Path | str:
    """Return where a distribution is on this machine, or the requirement by which pip finds it elsewhere.

    Installed from a folder, an archive or a repository it says so itself (PEP 610).
    """
    told: dict[str, Any] = json.loads(dist.read_text("direct_url.json") or "{}")
    url = told.get("url", "")
    if not url:
        return f"{dist.name}=={dist.version}"
    if url.startswith("file:"):
        return _local(dist, Path(unquote(urlsplit(url).path), told.get("subdirectory", "")))
    vcs = told.get("vcs_info")
    return f"{dist.name} @ {vcs['vcs']}+{url}@{vcs['commit_id']}" if vcs else f"{dist.name} @ {url}"


def _local(dist: Distribution, place: Path) -> Path:
    if not place.exists():
        raise DeployError(
            f"{dist.name} was installed from {place}, which is gone. Install it anew from where it is now"
        )
    return place
