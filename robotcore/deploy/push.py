"""Push a project: check it, send it, install it, start it, and wait until it is healthy."""

from __future__ import annotations

import getpass
import platform
import shutil
import subprocess
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

from robotcore.deploy import checks, health, simulation
from robotcore.deploy.agent.files import format_bytes, measure_size
from robotcore.deploy.agent.releases import NAME_FORMAT, WHEELS, Release
from robotcore.deploy.answers import BeginAnswer, Finding, InstallAnswer, Nothing, ProbeAnswer
from robotcore.deploy.bundle import Staged, stage
from robotcore.deploy.host import Host
from robotcore.deploy.progress import Step, Tell, begin
from robotcore.deploy.project import Project
from robotcore.deploy.rpc import Link
from robotcore.deploy.staging import git_environment
from robotcore.deploy.wheels import Target, wheels_for
from robotcore.errors import DeployError
from robotcore.hal.backend import load_backend
from robotcore.runtime.plan import DEFAULT_WORLD, RunRequest
from robotcore.sweep.spec import seeds_of, words_of
from robotcore.text import counted

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
    healthy_within_s: float = health.HEALTHY_WITHIN_S


def push(asked: Push, tell: Tell = print) -> str:
    """Do it, and tell step by step; return the release's name.

    Raises UnprovenError where it is not sent for what it does, DeployError where the robot does not take it, and
    UnhealthyError where it did not live and was rolled back. Whatever is raised, the old or the new release runs.
    """
    with TemporaryDirectory(prefix="robotcore-") as folder:
        proven = (
            checks.run_checks(checks.CHECKS_OF_PROJECT, asked.project, tell)
            if asked.is_proven
            else checks.skip_checks(tell)
        )
        begin(FILES, tell).say("what is to be sent is gathered")
        staged = stage(asked.project, Path(folder))
        if asked.is_proven:
            proven += checks.run_checks(simulation.CHECKS_OF_BUNDLE, staged, tell)
        release = new_release(asked.project, staged.requirements, proven)
        step = begin("robot", tell)
        with Link(asked.host, asked.ssh_config) as link:
            delivery = Delivery(link, release, staged, tell)
            delivery.look(step)
            name = delivery.make(is_offline=asked.is_offline)
            judged = health.Trial(asked.host, asked.ssh_config, begin(health.STEP, tell))
            return judged.follow(link, "activate", name, healthy_within_s=asked.healthy_within_s)


def state_after(step: str, asked: Push) -> str:
    """Return what a push that was cut short in a step leaves on the robot."""
    if step == health.STEP:
        return health.goes_on(asked.host, asked.ssh_config)
    return f"Nothing {'was sent to' if step in {*checks.NAMES, FILES} else 'has changed on'} {asked.host}"


BAD = ("error", "warning")
"""The levels of a doctor's findings that are told of in full, the worst first."""


class Delivery:
    """A release on its way to a robot that is connected to: it is to `look`, and then to `make`."""

    def __init__(self, link: Link, release: Release, staged: Staged, tell: Tell) -> None:
        self._link, self._release, self._staged, self._tell = link, release, staged, tell
        self._has_environment, self._target = False, Target("", "")

    def look(self, step: Step) -> None:
        """Tell what the robot is; raise DeployError where it cannot take a release of the project."""
        facts = self._link.call("probe", ProbeAnswer, requirements=self._release.requirements, is_push=True)
        room = f"{format_bytes(facts.free_bytes)} free"
        step.done(f"{facts.host}: {facts.machine}, {facts.system}, Python {facts.python}, {room}")
        self._target, self._has_environment = Target.of(facts), facts.has_environment
        self._target.require_python(self._staged.project)

    def make(self, *, is_offline: bool) -> str:
        """Send it, install what it needs, and let its doctor look; return the name that the robot has given it.

        Where that fails, the robot forgets it.
        """
        if is_offline and not self._has_environment:
            self._add_wheels()
        step = begin("sent", self._tell)
        begun = self._link.call(
            "begin", BeginAnswer, release=self._release.name, size=measure_size(self._staged.folder)
        )
        release = replace(self._release, name=begun.release)
        with self._forgetting(release.name):
            release.write(self._staged.folder)
            self._send(begun, step)
            self._install(release.name, is_offline=is_offline)
        return release.name

    @contextmanager
    def _forgetting(self, release: str) -> Iterator[None]:
        """While entered, whatever is raised lets the robot throw away what it got; where it cannot, it does later."""
        try:
            yield
        except BaseException:
            with suppress(DeployError):
                self._link.call("discard", Nothing, release=release)
            raise

    def _add_wheels(self) -> None:
        """Put them beside what is sent: they go with it, and no other push has to do with them."""
        step = begin("wheels", self._tell)
        wheels = wheels_for(self._release.requirements, self._target, step.say)
        shutil.copytree(wheels, self._staged.folder / WHEELS)
        step.done(f"{len(list(wheels.iterdir()))} for {self._target}")

    def _send(self, begun: BeginAnswer, step: Step) -> None:
        went = self._link.send(self._staged.folder, begun.to, begun.copy_from, _saying(step))
        step.done(f"{went.files} files, {went.changed} of them new, {format_bytes(went.sent)}", *self._staged.notes)

    def _install(self, release: str, *, is_offline: bool) -> None:
        step = begin("environment", self._tell)
        made = self._link.call(
            "install", InstallAnswer, on_say=lambda notice: step.say(notice.say), release=release, is_offline=is_offline
        )
        step.done(made.environment)
        _tell_findings(made.findings, begin("doctor", self._tell))


def _saying(step: Step) -> Callable[[int, float], None]:
    return lambda size, part: step.say(f"{part:.0%}, {format_bytes(size)}")


def _tell_findings(findings: Sequence[Finding], step: Step) -> None:
    """Tell what the doctor found. An error raises nothing: the trial shows whether the app lives with it."""
    counts = Counter(finding.level for finding in findings)
    bad = [finding for level in BAD for finding in findings if finding.level == level]
    said = [f"{counts['ok']} ok", *(counted(counts[level], level) for level in BAD if counts[level])]
    step.done(", ".join(said), *(_in_a_line(finding) for finding in bad))


def _in_a_line(finding: Finding) -> str:
    remedy = f". {finding.remedy}" if finding.remedy else ""
    return f"{finding.level}: {finding.what}: {finding.said}{remedy}"


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
