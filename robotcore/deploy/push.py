"""A project is proven, sent, installed, started, and watched until it lives."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from robotcore.deploy import gates, trial
from robotcore.deploy.delivery import Delivery
from robotcore.deploy.host import Host
from robotcore.deploy.link import Link
from robotcore.deploy.making import new_release
from robotcore.deploy.progress import Tell, begin
from robotcore.deploy.project import Project
from robotcore.deploy.staging import stage


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
    proven = _proven(asked, tell)
    step = begin("robot", tell)
    with TemporaryDirectory(prefix="robotcore-") as folder, Link(asked.host, asked.ssh_config) as link:
        step.say("what is to be sent is gathered")
        staged = stage(asked.project, Path(folder))
        release = new_release(asked.project, staged.requirements, proven)
        delivery = Delivery(link, release, staged, tell)
        delivery.look(step, asked.project)
        delivery.make(is_offline=asked.is_offline)
        judged = trial.Trial(asked.host, asked.ssh_config, begin(trial.STEP, tell))
        return judged.follow(link, "activate", release.name, healthy_within_s=asked.healthy_within_s)


def state_after(step: str, asked: Push) -> str:
    """Return what a push that was cut short in a step leaves on the robot."""
    if step == trial.STEP:
        return trial.goes_on(asked.host, asked.ssh_config)
    return f"Nothing {'was sent to' if step in {gate.name for gate in gates.GATES} else 'has changed on'} {asked.host}"


def _proven(asked: Push, tell: Tell) -> tuple[str, ...]:
    """Pass the gates; return a line for each, as the release keeps them."""
    if not asked.is_proven:
        begin("skipped", tell).done(", ".join(gate.name for gate in gates.GATES))
        return gates.lines_of(gates.skipped())
    proofs = {}
    for gate in gates.GATES:
        step = begin(gate.name, tell)
        proof = proofs[gate.name] = gate.prove(asked.project, step.say)
        step.done(proof.said, *proof.notes)
    return gates.lines_of(proofs)
