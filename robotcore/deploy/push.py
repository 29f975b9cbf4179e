"""The push of a project: check it, send it, install it, start it, and wait until it is healthy."""

from __future__ import annotations

import getpass
import platform
import shutil
import subprocess
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from pathlib import Path
from tempfile import TemporaryDirectory

from robotcore.compatibility import read_version
from robotcore.deploy import checks, rsync
from robotcore.deploy import health_progress as health
from robotcore.deploy.agent.files import format_bytes, measure_size
from robotcore.deploy.agent.releases import HEALTHY_WITHIN_S, NAME_FORMAT, WHEELS, Release
from robotcore.deploy.bundle import Bundle, build_bundle
from robotcore.deploy.checks import check_descriptions, run_check, run_tests
from robotcore.deploy.errors import BROKEN
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.progress import OnStep, Step
from robotcore.deploy.project import WHOLE_RUN, Project
from robotcore.deploy.robot_answers import BeginAnswer, EmptyAnswer, FindingMessage, InstallAnswer, ProbeAnswer
from robotcore.deploy.rpc import RobotLink
from robotcore.deploy.simulation import simulate
from robotcore.deploy.staging import build_git_environment
from robotcore.deploy.wheels import Platform, fetch_wheels
from robotcore.errors import DeployError
from robotcore.hal.backend import load_backend
from robotcore.runtime.plan import DEFAULT_WORLD, RunRequest
from robotcore.sweep.spec import format_options, parse_seeds
from robotcore.text import pluralize

__all__ = ["PushRequest", "push"]

ROBOT = "robot"
"""The name of the step that connects to the robot, before the checks, and then probes it, after the checks."""

FILES = "files"
"""The name of the step that builds the bundle. This step reports no result."""


@dataclass(frozen=True)
class PushRequest:
    """The project, the robot and the options of a push.

    >>> from pathlib import Path
    >>> from robotcore.deploy.host import RobotAddress
    >>> from robotcore.deploy.project import DeployOptions, build_project
    >>> project = build_project(DeployOptions(app="green-search", robot="rover"), Path("/"))
    >>> request = PushRequest(RobotAddress.parse("pi@rover.local"), project, is_offline=True)
    >>> str(request.host), request.is_checked
    ('pi@rover.local', True)
    """

    host: RobotAddress
    project: Project
    is_checked: bool = True
    """Whether the checks run first: the tests, the check of the descriptions, and the simulation."""

    is_offline: bool = False
    """Whether the push also sends the wheels of the requirements, for a robot without a network."""

    healthy_within_s: float = HEALTHY_WITHIN_S
    """The time limit for the app's first tick on the robot, in s."""


def push(request: PushRequest, on_step: OnStep = print) -> str:
    """Check a project, send it to a robot, and start it there. Return the release's name.

    Connects to the robot first, because the checks take long.

    After any error, the robot has the complete old or the complete new release.

    request: the project, the robot and the options.
    on_step: this function is called with the progress.
    Raises ReleaseCheckError if a check fails, before anything is sent. Raises DeployError if the robot cannot be
    reached or cannot run the project. Raises UnhealthyError if the robot has rolled back the release.

    >>> from pathlib import Path
    >>> from robotcore.deploy.host import RobotAddress
    >>> from robotcore.deploy.project import DeployOptions, build_project
    >>> from robotcore.deploy.push import PushRequest
    >>> from robotcore.errors import DeployError
    >>> project = build_project(DeployOptions(app="green-search", robot="rover"), Path("/"))
    >>> try:
    ...     push(PushRequest(RobotAddress.parse("pi@127.0.0.1:1"), project), on_step=lambda _: None)
    ... except DeployError:
    ...     print("nothing has changed on the robot")
    nothing has changed on the robot
    """
    Step(ROBOT, on_step)  # without a text, because ssh may ask for a password
    with (
        RobotLink(request.host) as link,
        TemporaryDirectory(prefix="robotcore-") as folder,
    ):
        bundle, check_lines = _build_checked_bundle(request, Path(folder), on_step)
        release = create_release(request.project, bundle.requirements, check_lines)
        facts = _probe(link, release, Step(ROBOT, on_step))
        target = Platform(facts.python, facts.machine, facts.libc, facts.libc_version)
        target.require_python(request.project)
        if request.is_offline and not facts.has_environment:
            step = Step("wheels", on_step)
            wheels = shutil.copytree(fetch_wheels(release.requirements, target, step.update), bundle.folder / WHEELS)
            step.finish(f"{len(list(wheels.iterdir()))} for {target}")
        name = _upload(link, release, bundle, on_step, is_offline=request.is_offline)
        step = Step(health.STEP, on_step)
        return health.follow_check(link, step, "activate", name, request.healthy_within_s)


def _build_checked_bundle(request: PushRequest, folder: Path, on_step: OnStep) -> tuple[Bundle, tuple[str, ...]]:
    """Return the bundle, and a line for each check with its result."""
    project, lines = request.project, []
    if request.is_checked:
        lines.append(run_check("tests", run_tests, project, on_step))
        lines.append(run_check("check", check_descriptions, project, on_step))
    else:
        Step("skipped", on_step).finish(", ".join(checks.NAMES))
    Step(FILES, on_step).update("collecting the files")
    bundle = build_bundle(project, folder)
    if not request.is_checked:
        return bundle, tuple(f"{name}: skipped" for name in checks.NAMES)
    return bundle, (*lines, run_check("simulation", simulate, bundle, on_step))


def describe_state_after(step: str, request: PushRequest) -> str:
    """Return a sentence about the state of the robot after a push that ended in this step."""
    if step == health.STEP:
        return health.build_status_hint(request.host)
    return f"Nothing {'was sent to' if step in {*checks.NAMES, FILES} else 'has changed on'} {request.host}"


SHOWN_LEVELS = ("error", "warning")
"""The levels of the doctor's findings that the push reports in full, the worst first."""


def _probe(link: RobotLink, release: Release, step: Step) -> ProbeAnswer:
    """Report the robot's system. Raises DeployError if the robot cannot receive a push."""
    try:
        facts = link.call("probe", ProbeAnswer, requirements=release.requirements)
    except DeployError as error:
        if error.kind != BROKEN:
            raise
        link.reconnect()  # the connection may break during the checks, which take long
        facts = link.call("probe", ProbeAnswer, requirements=release.requirements)
    room = f"{format_bytes(facts.free_bytes)} free"
    step.finish(f"{facts.host}: {facts.machine}, {facts.system}, Python {facts.python}, {room}")
    return facts


def _upload(link: RobotLink, release: Release, bundle: Bundle, on_step: OnStep, *, is_offline: bool) -> str:
    """Send the release, install its requirements, and run its doctor. Return the name that the robot gave it."""
    step = Step("sent", on_step)
    begun = link.call("begin", BeginAnswer, release=release.name, size=measure_size(bundle.folder))
    with _discard_on_error(link, begun.release):
        replace(release, name=begun.release).write(bundle.folder)
        done = rsync.send(
            link,
            bundle.folder,
            begun.to,
            begun.copy_from,
            lambda size, part: step.update(f"{part:.0%}, {format_bytes(size)}"),
        )
        size = format_bytes(done.sent)
        step.finish(f"{done.files} files, {done.changed} of them new, {size}", *bundle.warnings)
        step = Step("environment", on_step)
        made = link.call(
            "install",
            InstallAnswer,
            on_message=lambda message: step.update(message.text),
            release=begun.release,
            is_offline=is_offline,
        )
        step.finish(made.environment)
        _report_findings(made.findings, Step("doctor", on_step))
    return begun.release


@contextmanager
def _discard_on_error(link: RobotLink, release: str) -> Iterator[None]:
    """Make the robot delete the upload if the ``with`` block raises. If this fails, the next push deletes it."""
    try:
        yield
    except BaseException:
        with suppress(DeployError):
            link.call("discard", EmptyAnswer, release=release)
        raise


def _report_findings(findings: Sequence[FindingMessage], step: Step) -> None:
    """Report the doctor's findings. An error among them does not end the push, because the health check decides."""
    counts = Counter(finding.level for finding in findings)
    said = [f"{counts['ok']} ok", *(pluralize(counts[level], level) for level in SHOWN_LEVELS if counts[level])]
    bad = [finding for level in SHOWN_LEVELS for finding in findings if finding.level == level]
    details = [f"{it.level}: {it.subject}: {it.message}{f'. {it.remedy}' if it.remedy else ''}" for it in bad]
    step.finish(", ".join(said), *details)


UNTIL_STOPPED_S = 1e9
"""The time-out of a run on the robot, in s: about 30 years."""


def create_release(project: Project, requirements: tuple[str, ...] = (), check_lines: tuple[str, ...] = ()) -> Release:
    """Return the manifest of a new release. Its name is the current time, but the robot may give it a later name.

    requirements: the requirements that pip installs on the robot.
    check_lines: a line for each check before the push, with its result.
    """
    view, stop_options = project.deploy.view, format_options(RunRequest(project.app, options=project.deploy.options))
    return Release(
        name=f"{datetime.now(timezone.utc):{NAME_FORMAT}}",
        project=project.name,
        app=project.app,
        robot=project.robot,
        backend=project.deploy.backend,
        run=(
            "run",
            project.app,
            *format_options(_build_run_request(project)),
            *(("--view", str(view)) if view else ()),
        ),
        stop=("stop", "--backend", project.deploy.backend, "--robot", project.robot, *stop_options),
        requirements=requirements,
        checks=check_lines,
        robotcore=read_version(),
        revision=_find_revision(project.folder),
        sender=f"{getpass.getuser()}@{platform.node()}",
        is_recorded=project.deploy.record,
        record_last="" if project.deploy.record_last == WHOLE_RUN else project.deploy.record_last,
        view_port=view,
    )


def _build_run_request(project: Project) -> RunRequest:
    is_simulated = load_backend(project.deploy.backend).builds_world(project.load_description())
    return RunRequest(
        app=project.app,
        backend=project.deploy.backend,
        robot=project.robot,
        world=(project.world or DEFAULT_WORLD) if is_simulated else None,
        seed=parse_seeds(project.deploy.seeds)[0] if is_simulated else None,
        rate_hz=project.deploy.rate_hz,
        timeout_s=UNTIL_STOPPED_S,
        settings=project.deploy.settings,
        options=project.deploy.options,
        realtime=True,
        has_real_time_priority=project.deploy.rt,
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
