"""A project as a release: how the robot runs it, and how it makes the motors stand without it."""

from __future__ import annotations

import getpass
import platform
import subprocess
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path

from robotcore.deploy.agent.releases import NAME_FORMAT, Release
from robotcore.deploy.project import Project
from robotcore.deploy.staging.files import git_environment
from robotcore.hal.backend import load_backend
from robotcore.runtime.plan import DEFAULT_WORLD, RunRequest
from robotcore.sweep.spec import seeds_of, words_of

UNTIL_STOPPED_S = 1e9
"""A deployed app runs until somebody stops it: the time-out of a run is 30 years."""


def new_release(project: Project, requirements: tuple[str, ...], proven: tuple[str, ...]) -> Release:
    """Return the release of a project at this moment; the robot has a later name for it where its newest is later."""
    return release_of(
        project,
        f"{datetime.now(timezone.utc):{NAME_FORMAT}}",
        requirements=requirements,
        gates=proven,
        robotcore=version("robotcore"),
        revision=_revision_of(project.folder),
        sender=f"{getpass.getuser()}@{platform.node()}",
    )


def release_of(
    project: Project,
    name: str,
    *,
    requirements: tuple[str, ...] = (),
    gates: tuple[str, ...] = (),
    robotcore: str = "",
    revision: str = "",
    sender: str = "",
) -> Release:
    """Return the release of that name; what it is run with holds in the folder that the project has there."""
    return Release(
        name=name,
        project=project.name,
        app=project.app,
        robot=project.robot,
        backend=project.backend,
        run=("run", project.app, *words_of(_request(project))),
        stop=("stop", "--backend", project.backend, "--robot", project.robot, *_options(project)),
        requirements=requirements,
        gates=gates,
        robotcore=robotcore,
        revision=revision,
        sender=sender,
        is_recorded=project.is_recorded,
    )


def _options(project: Project) -> list[str]:
    return words_of(RunRequest(project.app, options=project.options))


def _request(project: Project) -> RunRequest:
    """Return the run on the robot; where that has a simulator in it, in the world and with the first seed given."""
    is_simulated = load_backend(project.backend).builds_world(project.described())
    return RunRequest(
        app=project.app,
        backend=project.backend,
        robot=project.robot,
        world=(project.world or DEFAULT_WORLD) if is_simulated else None,
        seed=seeds_of(project.seeds)[0] if is_simulated else None,
        rate_hz=project.rate_hz,
        timeout_s=UNTIL_STOPPED_S,
        settings=project.settings,
        options=project.options,
        realtime=True,
    )


def _revision_of(folder: Path | None) -> str:
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
