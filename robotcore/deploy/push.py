"""A project is proven, sent, installed, started, and watched until it lives."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from robotcore.deploy import trial
from robotcore.deploy.connection.host import Host
from robotcore.deploy.connection.link import Link
from robotcore.deploy.delivery import Delivery
from robotcore.deploy.manifest import new_release
from robotcore.deploy.progress import Tell, begin
from robotcore.deploy.project import Project
from robotcore.deploy.proof import gates
from robotcore.deploy.staging.staging import stage

FILES = "files"
"""The step in which what is to be sent is gathered: nothing comes of it to be told."""


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
    healthy_within_s: float = trial.HEALTHY_WITHIN_S


def push(asked: Push, tell: Tell = print) -> str:
    """Do it, and tell step by step; return the release's name.

    Raises UnprovenError where it is not sent for what it does, DeployError where the robot does not take it, and
    UnhealthyError where it did not live and was rolled back. Whatever is raised, the old or the new release runs.
    """
    with TemporaryDirectory(prefix="robotcore-") as folder:
        proven = gates.passed(gates.AT_DESK, asked.project, tell) if asked.is_proven else gates.skipped(tell)
        begin(FILES, tell).say("what is to be sent is gathered")
        staged = stage(asked.project, Path(folder))
        if asked.is_proven:
            proven += gates.passed(gates.AS_SENT, staged, tell)
        release = new_release(asked.project, staged.requirements, proven)
        step = begin("robot", tell)
        with Link(asked.host, asked.ssh_config) as link:
            delivery = Delivery(link, release, staged, tell)
            delivery.look(step)
            name = delivery.make(is_offline=asked.is_offline)
            judged = trial.Trial(asked.host, asked.ssh_config, begin(trial.STEP, tell))
            return judged.follow(link, "activate", name, healthy_within_s=asked.healthy_within_s)


def state_after(step: str, asked: Push) -> str:
    """Return what a push that was cut short in a step leaves on the robot."""
    if step == trial.STEP:
        return trial.goes_on(asked.host, asked.ssh_config)
    return f"Nothing {'was sent to' if step in {*gates.NAMES, FILES} else 'has changed on'} {asked.host}"
