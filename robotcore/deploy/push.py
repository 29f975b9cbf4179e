"""The push of a project: check it, send it, install it, start it, and wait until it is healthy."""

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

from robotcore.deploy import checks, simulation
from robotcore.deploy import health_progress as health
from robotcore.deploy.agent.files import format_bytes, measure_size
from robotcore.deploy.agent.releases import NAME_FORMAT, WHEELS, Release
from robotcore.deploy.bundle import Bundle, build_bundle
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.progress import OnStep, StepReporter, begin_step
from robotcore.deploy.project import Project
from robotcore.deploy.robot_answers import BeginAnswer, EmptyAnswer, FindingMessage, InstallAnswer, ProbeAnswer
from robotcore.deploy.rpc import RobotLink
from robotcore.deploy.staging import build_git_environment
from robotcore.deploy.wheels import Platform, fetch_wheels
from robotcore.errors import DeployError
from robotcore.hal.backend import load_backend
from robotcore.runtime.plan import DEFAULT_WORLD, RunRequest
from robotcore.sweep.spec import format_options, parse_seeds
from robotcore.text import pluralize

ROBOT = "robot"
"""The name of the step that connects to the robot, before the checks, and then probes it, after the checks."""

FILES = "files"
"""The name of the step that builds the bundle. This step reports no result."""


@dataclass(frozen=True)
class Push:
    """The project, the robot and the options of a push."""

    host: RobotAddress
    project: Project
    ssh_config: Path | None = None
    """An ssh configuration in place of the user's."""

    is_checked: bool = True
    """Whether the checks run first: the tests, the check of the descriptions, and the simulation."""

    is_offline: bool = False
    """Whether the push also sends the wheels of the requirements, for a robot without a network."""

    healthy_within_s: float = health.HEALTHY_WITHIN_S
    """The time limit for the app's first tick on the robot, in s."""


def push(request: Push, on_step: OnStep = print) -> str:
    """Check a project, send it to a robot, and start it there. Return the release's name.

    Connects to the robot first, because the checks take long.

    After any error, the robot has the complete old or the complete new release.

    request: the project, the robot and the options.
    on_step: this function is called with the progress.
    Raises UnprovenError if a check fails, before anything is sent. Raises DeployError if the robot cannot be reached or
    cannot run the project. Raises UnhealthyError if the robot has rolled back the release.
    """
    begin_step(ROBOT, on_step)  # without an update, because ssh may ask for a password
    with (
        RobotLink(request.host, request.ssh_config) as link,
        TemporaryDirectory(prefix="robotcore-") as folder,
    ):
        check_lines = (
            checks.run_checks(checks.CHECKS_OF_PROJECT, request.project, on_step)
            if request.is_checked
            else checks.skip_checks(on_step)
        )
        begin_step(FILES, on_step).update("collecting the files")
        bundle = build_bundle(request.project, Path(folder))
        if request.is_checked:
            check_lines += checks.run_checks(simulation.CHECKS_OF_BUNDLE, bundle, on_step)
        release = create_release(request.project, bundle.requirements, check_lines)
        upload = ReleaseUpload(link, release, bundle, on_step)
        upload.probe(begin_step(ROBOT, on_step))
        name = upload.upload(is_offline=request.is_offline)
        check = health.HealthCheckClient(request.host, request.ssh_config, begin_step(health.STEP, on_step))
        return check.follow(link, "activate", name, healthy_within_s=request.healthy_within_s)


def describe_state_after(step: str, request: Push) -> str:
    """Return a sentence about the state of the robot after a push that ended in this step."""
    if step == health.STEP:
        return health.status_hint(request.host, request.ssh_config)
    return f"Nothing {'was sent to' if step in {*checks.NAMES, FILES} else 'has changed on'} {request.host}"


SHOWN_LEVELS = ("error", "warning")
"""The levels of the doctor's findings that the push reports in full, the worst first."""


class ReleaseUpload:
    """Uploads a release to a robot. Call `probe` first, then `upload`.

    link: an open link to the robot.
    release: the manifest.
    bundle: the folder to send.
    on_step: this function is called with the progress.
    """

    def __init__(self, link: RobotLink, release: Release, bundle: Bundle, on_step: OnStep) -> None:
        self._link, self._release, self._bundle, self._on_step = link, release, bundle, on_step
        self._has_environment, self._target = False, Platform("", "")

    def probe(self, step: StepReporter) -> None:
        """Report the robot's system; raises DeployError if the project cannot run on it."""
        facts = self._link.call("probe", ProbeAnswer, requirements=self._release.requirements, is_push=True)
        room = f"{format_bytes(facts.free_bytes)} free"
        step.finish(f"{facts.host}: {facts.machine}, {facts.system}, Python {facts.python}, {room}")
        self._target, self._has_environment = Platform.of(facts), facts.has_environment
        self._target.require_python(self._bundle.project)

    def upload(self, *, is_offline: bool) -> str:
        """Send the release, install its requirements, and run its doctor. Return the name that the robot gave it.

        After an error, the robot deletes the upload.
        """
        if is_offline and not self._has_environment:
            self._add_wheels()
        step = begin_step("sent", self._on_step)
        begun = self._link.call(
            "begin", BeginAnswer, release=self._release.name, size=measure_size(self._bundle.folder)
        )
        release = replace(self._release, name=begun.release)
        with self._discard_on_error(release.name):
            release.write(self._bundle.folder)
            self._send(begun, step)
            self._install(release.name, is_offline=is_offline)
        return release.name

    @contextmanager
    def _discard_on_error(self, release: str) -> Iterator[None]:
        """Make the robot delete the upload if the ``with`` block raises. If this fails, the next push deletes it."""
        try:
            yield
        except BaseException:
            with suppress(DeployError):
                self._link.call("discard", EmptyAnswer, release=release)
            raise

    def _add_wheels(self) -> None:
        step = begin_step("wheels", self._on_step)
        wheels = fetch_wheels(self._release.requirements, self._target, step.update)
        shutil.copytree(wheels, self._bundle.folder / WHEELS)
        step.finish(f"{len(list(wheels.iterdir()))} for {self._target}")

    def _send(self, begun: BeginAnswer, step: StepReporter) -> None:
        done = self._link.send(self._bundle.folder, begun.to, begun.copy_from, _report_transfer(step))
        step.finish(
            f"{done.files} files, {done.changed} of them new, {format_bytes(done.sent)}", *self._bundle.warnings
        )

    def _install(self, release: str, *, is_offline: bool) -> None:
        step = begin_step("environment", self._on_step)
        made = self._link.call(
            "install",
            InstallAnswer,
            on_message=lambda message: step.update(message.text),
            release=release,
            is_offline=is_offline,
        )
        step.finish(made.environment)
        _report_findings(made.findings, begin_step("doctor", self._on_step))


def _report_transfer(step: StepReporter) -> Callable[[int, float], None]:
    return lambda size, part: step.update(f"{part:.0%}, {format_bytes(size)}")


def _report_findings(findings: Sequence[FindingMessage], step: StepReporter) -> None:
    """Report the doctor's findings. An error among them does not end the push, because the health check decides."""
    counts = Counter(finding.level for finding in findings)
    bad = [finding for level in SHOWN_LEVELS for finding in findings if finding.level == level]
    said = [f"{counts['ok']} ok", *(pluralize(counts[level], level) for level in SHOWN_LEVELS if counts[level])]
    step.finish(", ".join(said), *(_format_finding(finding) for finding in bad))


def _format_finding(finding: FindingMessage) -> str:
    remedy = f". {finding.remedy}" if finding.remedy else ""
    return f"{finding.level}: {finding.what}: {finding.said}{remedy}"


UNTIL_STOPPED_S = 1e9
"""The time-out of a run on the robot, in s: about 30 years."""


def create_release(project: Project, requirements: tuple[str, ...], check_lines: tuple[str, ...]) -> Release:
    """Return the manifest of a new release. Its name is the current time, but the robot may give it a later name.

    requirements: the requirements that pip installs on the robot.
    check_lines: a line for each check before the push, with its result.
    """
    return build_release(
        project,
        f"{datetime.now(timezone.utc):{NAME_FORMAT}}",
        requirements=requirements,
        check_lines=check_lines,
        robotcore=version("robotcore"),
        revision=_find_revision(project.folder),
        sender=f"{getpass.getuser()}@{platform.node()}",
    )


def build_release(
    project: Project,
    name: str,
    *,
    requirements: tuple[str, ...] = (),
    check_lines: tuple[str, ...] = (),
    robotcore: str = "",
    revision: str = "",
    sender: str = "",
) -> Release:
    """Return the manifest of a release. For the parameters, see the fields of `Release`."""
    return Release(
        name=name,
        project=project.name,
        app=project.app,
        robot=project.robot,
        backend=project.backend,
        run=("run", project.app, *format_options(_build_run_request(project))),
        stop=("stop", "--backend", project.backend, "--robot", project.robot, *_build_stop_options(project)),
        requirements=requirements,
        checks=check_lines,
        robotcore=robotcore,
        revision=revision,
        sender=sender,
        is_recorded=project.is_recorded,
    )


def _build_stop_options(project: Project) -> list[str]:
    return format_options(RunRequest(project.app, options=project.options))


def _build_run_request(project: Project) -> RunRequest:
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
    """Return the git commit of a folder, with ``-dirty`` after uncommitted changes; empty without git."""
    if folder is None:
        return ""
    command = ("git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*")
    try:
        process = subprocess.run(  # noqa: S603  constants
            command, cwd=folder, env=build_git_environment(), capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        return ""
    return process.stdout.strip()
