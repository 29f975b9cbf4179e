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
from robotcore.deploy.answers import BeginAnswer, EmptyAnswer, Finding, InstallAnswer, ProbeAnswer
from robotcore.deploy.bundle import Bundle, build_bundle
from robotcore.deploy.host import Host
from robotcore.deploy.progress import OnStep, Step, begin_step
from robotcore.deploy.project import Project
from robotcore.deploy.rpc import Link
from robotcore.deploy.staging import git_environment
from robotcore.deploy.wheels import Target, fetch_wheels
from robotcore.errors import DeployError
from robotcore.hal.backend import load_backend
from robotcore.runtime.plan import DEFAULT_WORLD, RunRequest
from robotcore.sweep.spec import format_options, parse_seeds
from robotcore.text import pluralize

FILES = "files"
"""The name of the step that builds the bundle; it prints no result."""


@dataclass(frozen=True)
class Push:
    """The options of a push."""

    host: Host
    project: Project
    ssh_config: Path | None = None
    """An ssh configuration in place of the user's."""

    is_checked: bool = True
    """Run the tests, the checks of the descriptions and the simulation first."""

    is_offline: bool = False
    """Send the wheels too: the robot has no network."""

    healthy_within_s: float = health.HEALTHY_WITHIN_S
    """The time to the first tick of the release."""


def push(request: Push, on_step: OnStep = print) -> str:
    """Do it, and tell step by step; return the release's name.

    Raises UnprovenError where it is not sent for what it does, DeployError where the robot does not take it, and
    UnhealthyError where it did not live and was rolled back. Whatever is raised, the old or the new release runs.
    """
    with TemporaryDirectory(prefix="robotcore-") as folder:
        checks_passed = (
            checks.run_checks(checks.CHECKS_OF_PROJECT, request.project, on_step)
            if request.is_checked
            else checks.skip_checks(on_step)
        )
        begin_step(FILES, on_step).update("what is to be sent is gathered")
        bundle = build_bundle(request.project, Path(folder))
        if request.is_checked:
            checks_passed += checks.run_checks(simulation.CHECKS_OF_BUNDLE, bundle, on_step)
        release = new_release(request.project, bundle.requirements, checks_passed)
        step = begin_step("robot", on_step)
        with Link(request.host, request.ssh_config) as link:
            upload = ReleaseUpload(link, release, bundle, on_step)
            upload.probe(step)
            name = upload.upload(is_offline=request.is_offline)
            check = health.HealthCheck(request.host, request.ssh_config, begin_step(health.STEP, on_step))
            return check.follow(link, "activate", name, healthy_within_s=request.healthy_within_s)


def describe_state_after(step: str, request: Push) -> str:
    """Return what a push that was cut short in a step leaves on the robot."""
    if step == health.STEP:
        return health.status_hint(request.host, request.ssh_config)
    return f"Nothing {'was sent to' if step in {*checks.NAMES, FILES} else 'has changed on'} {request.host}"


SHOWN_LEVELS = ("error", "warning")
"""The levels of findings that are printed in full, the worst first."""


class ReleaseUpload:
    """The upload of a release to a connected robot: call `probe`, then `upload`."""

    def __init__(self, link: Link, release: Release, bundle: Bundle, on_step: OnStep) -> None:
        self._link, self._release, self._bundle, self._on_step = link, release, bundle, on_step
        self._has_environment, self._target = False, Target("", "")

    def probe(self, step: Step) -> None:
        """Report the robot's system; raises DeployError if the project cannot run on it."""
        facts = self._link.call("probe", ProbeAnswer, requirements=self._release.requirements, is_push=True)
        room = f"{format_bytes(facts.free_bytes)} free"
        step.finish(f"{facts.host}: {facts.machine}, {facts.system}, Python {facts.python}, {room}")
        self._target, self._has_environment = Target.of(facts), facts.has_environment
        self._target.require_python(self._bundle.project)

    def upload(self, *, is_offline: bool) -> str:
        """Send the release, install its requirements and run its doctor; return the name that the robot gave it.

        If a step fails, the robot deletes the release.
        """
        if is_offline and not self._has_environment:
            self._add_wheels()
        step = begin_step("sent", self._on_step)
        begun = self._link.call(
            "begin", BeginAnswer, release=self._release.name, size=measure_size(self._bundle.folder)
        )
        release = replace(self._release, name=begun.release)
        with self._discarding(release.name):
            release.write(self._bundle.folder)
            self._send(begun, step)
            self._install(release.name, is_offline=is_offline)
        return release.name

    @contextmanager
    def _discarding(self, release: str) -> Iterator[None]:
        """While entered, whatever is raised lets the robot throw away what it got; where it cannot, it does later."""
        try:
            yield
        except BaseException:
            with suppress(DeployError):
                self._link.call("discard", EmptyAnswer, release=release)
            raise

    def _add_wheels(self) -> None:
        """Put them beside what is sent: they go with it, and no other push has to do with them."""
        step = begin_step("wheels", self._on_step)
        wheels = fetch_wheels(self._release.requirements, self._target, step.update)
        shutil.copytree(wheels, self._bundle.folder / WHEELS)
        step.finish(f"{len(list(wheels.iterdir()))} for {self._target}")

    def _send(self, begun: BeginAnswer, step: Step) -> None:
        went = self._link.send(self._bundle.folder, begun.to, begun.copy_from, _report_transfer(step))
        step.finish(f"{went.files} files, {went.changed} of them new, {format_bytes(went.sent)}", *self._bundle.notes)

    def _install(self, release: str, *, is_offline: bool) -> None:
        step = begin_step("environment", self._on_step)
        made = self._link.call(
            "install",
            InstallAnswer,
            on_notice=lambda notice: step.update(notice.say),
            release=release,
            is_offline=is_offline,
        )
        step.finish(made.environment)
        _report_findings(made.findings, begin_step("doctor", self._on_step))


def _report_transfer(step: Step) -> Callable[[int, float], None]:
    return lambda size, part: step.update(f"{part:.0%}, {format_bytes(size)}")


def _report_findings(findings: Sequence[Finding], step: Step) -> None:
    """Tell what the doctor found. An error raises nothing: the trial shows whether the app lives with it."""
    counts = Counter(finding.level for finding in findings)
    bad = [finding for level in SHOWN_LEVELS for finding in findings if finding.level == level]
    said = [f"{counts['ok']} ok", *(pluralize(counts[level], level) for level in SHOWN_LEVELS if counts[level])]
    step.finish(", ".join(said), *(_format_finding(finding) for finding in bad))


def _format_finding(finding: Finding) -> str:
    remedy = f". {finding.remedy}" if finding.remedy else ""
    return f"{finding.level}: {finding.what}: {finding.said}{remedy}"


UNTIL_STOPPED_S = 1e9
"""A deployed app runs until somebody stops it: the time-out of a run is 30 years."""


def new_release(project: Project, requirements: tuple[str, ...], checks_passed: tuple[str, ...]) -> Release:
    """Return the release of a project at this moment; the robot has a later name for it where its newest is later."""
    return build_release(
        project,
        f"{datetime.now(timezone.utc):{NAME_FORMAT}}",
        requirements=requirements,
        gates=checks_passed,
        robotcore=version("robotcore"),
        revision=_find_revision(project.folder),
        sender=f"{getpass.getuser()}@{platform.node()}",
    )


def build_release(
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
        run=("run", project.app, *format_options(_build_request(project))),
        stop=("stop", "--backend", project.backend, "--robot", project.robot, *_option_arguments(project)),
        requirements=requirements,
        gates=gates,
        robotcore=robotcore,
        revision=revision,
        sender=sender,
        is_recorded=project.is_recorded,
    )


def _option_arguments(project: Project) -> list[str]:
    return format_options(RunRequest(project.app, options=project.options))


def _build_request(project: Project) -> RunRequest:
    """Return the run on the robot; where that has a simulator in it, in the world and with the first seed given."""
    is_simulated = load_backend(project.backend).builds_world(project.load_description())
    return RunRequest(
        app=project.app,
        backend=project.backend,
        robot=project.robot,
        world=(project.world or DEFAULT_WORLD) if is_simulated else None,
        seed=parse_seeds(project.seeds)[0] if is_simulated else None,
        rate_hz=project.rate_hz,
        timeout_s=UNTIL_STOPPED_S,
        settings=project.settings,
        options=project.options,
        realtime=True,
    )


def _find_revision(folder: Path | None) -> str:
    """Return the commit that a folder is at, ``-dirty`` behind it where it was changed since; empty without git."""
    if folder is None:
        return ""
    command = ("git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*")
    try:
        process = subprocess.run(  # noqa: S603  constants
            command, cwd=folder, env=git_environment(), capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        return ""
    return process.stdout.strip()
