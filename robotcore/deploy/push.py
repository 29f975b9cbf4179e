"""A project is proven, sent, installed, started, and watched until it lives."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from robotcore.deploy.host import Host
from robotcore.deploy.progress import Tell, begin
from robotcore.deploy.project import Project

HEALTHY_WITHIN_S = 60.0
"""A release has so long for its first tick: a Pi imports NumPy and OpenCV, and its camera settles."""

STEPS = ("tests", "check", "simulation", "robot", "sent", "environment", "doctor", "release")
"""In their order. Until the last one nothing that runs on the robot is touched; in the last one, it judges by itself."""


@dataclass(frozen=True)
class Push:
    """What is to be put where.

    ``ssh_config`` is an ssh configuration instead of the user's. Without ``is_proven`` there are no tests, no check and
    no simulation; with ``is_offline`` the wheels are brought along. ``healthy_within_s`` is the time to the first tick.
    """

    host: Host
    project: Project
    ssh_config: Path | None = None
    is_proven: bool = True
    is_offline: bool = False
    healthy_within_s: float = HEALTHY_WITHIN_S


def push(asked: Push, tell: Tell = print) -> str:
    """Do it, and tell step by step; return the release's name.

    Raises UnprovenError where it is not sent for what it does, DeployError where the robot does not take it, and
    UnhealthyError where it did not live and was rolled back. Whatever is raised, the old or the new release runs.
    """
    raise NotImplementedError
