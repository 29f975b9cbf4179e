"""A release as it is made now: its name, and what tells later where it came from."""

from __future__ import annotations

import getpass
import platform
import subprocess
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path

from robotcore.deploy.aboard.release import Release
from robotcore.deploy.files import git_environment
from robotcore.deploy.manifest import release_of
from robotcore.deploy.project import Project


def new_release(project: Project, requirements: tuple[str, ...], proven: tuple[str, ...]) -> Release:
    """Return the release of a project at this moment."""
    return release_of(
        project,
        f"{datetime.now(timezone.utc):%Y-%m-%dT%H-%M-%SZ}",
        requirements=requirements,
        gates=proven,
        robotcore=version("robotcore"),
        revision=revision_of(project.folder),
        sender=f"{getpass.getuser()}@{platform.node()}",
    )


def revision_of(folder: Path | None) -> str:
    """Return the commit that a folder is at, ``-dirty`` behind it where it was changed since; empty without git."""
    if folder is None:
        return ""
    command = ("git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*")
    try:
        asked = subprocess.run(  # noqa: S603  constants
            command, cwd=folder, env=git_environment(), capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        return ""
    return asked.stdout.strip()
