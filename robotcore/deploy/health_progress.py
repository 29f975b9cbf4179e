"""The client's part of a health check: begin it on the robot, report its progress, and return its result.

The check itself runs on the robot, and goes on if the connection breaks.
"""

from __future__ import annotations

from robotcore.deploy.agent.releases import HEALTHY, HEALTHY_WITHIN_S, UNHEALTHY
from robotcore.deploy.errors import BROKEN, TRANSIENT
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.progress import OnStep, Step
from robotcore.deploy.robot_answers import HealthAnswer, ProgressMessage
from robotcore.deploy.rpc import RobotLink
from robotcore.errors import DeployError, UnhealthyError, UsageError
from robotcore.hal.wall_clock import MonotonicClock

STEP = "release"
"""The name of the step in progress reports."""

ATTEMPTS, PAUSE_S = 10, 3.0
"""The number of attempts to connect again after the connection broke, and the pause before each attempt, in s."""

ERROR_PREFIX, NO_MODULE = "error: ", "ModuleNotFoundError: "
"""The first is the beginning of an error message of robotcore. The second is in the message if a package is missing."""

RECONNECTING = "the connection broke; connecting again, while the health check continues on the robot"

UNKNOWN_RELEASE = "name"
"""The kind of a DeployError if the robot has no release of that name."""


def rollback(host: RobotAddress, release: str | None, on_step: OnStep = print) -> str:
    """Make an older release the current one, and wait until its health check ends. Return the release's name.

    release: the release's name; None for the newest healthy release before the current one.
    on_step: this function is called with the progress.
    Raises UsageError if the robot has no release of that name, and the errors of `follow_check`.
    """
    with RobotLink(host) as link:
        try:
            return follow_check(link, Step(STEP, on_step), "rollback", release, HEALTHY_WITHIN_S)
        except DeployError as error:
            if error.kind == UNKNOWN_RELEASE:
                raise UsageError(str(error)) from error
            raise


def follow_check(link: RobotLink, step: Step, action: str, release: str | None, healthy_within_s: float) -> str:
    """Make the robot check a release, and report the progress. Return the name of the healthy release.

    If the connection breaks, the function connects again, unless ssh fails for a reason that lasts, such as a changed
    host key. It needs the release's name to ask for the result.

    link: an open link to the robot.
    step: reports the progress of the check.
    action: ``activate`` or ``rollback``.
    release: the release's name; None if the robot shall choose the release.
    healthy_within_s: the time limit for the app's first tick, in s.
    Raises UnhealthyError if the release is not healthy, and DeployError if the client does not get the result.
    """

    def show_message(message: ProgressMessage) -> None:
        nonlocal release
        release = message.release or release
        step.update(message.text)

    clock = MonotonicClock()
    for attempt in range(1 + ATTEMPTS):
        try:
            if attempt:
                step.update(RECONNECTING)
                clock.sleep_until(clock.now() + PAUSE_S)
                link.reconnect()
            result = link.call(
                action, HealthAnswer, on_message=show_message, release=release, healthy_within_s=healthy_within_s
            )
            break
        except DeployError as error:
            if attempt == 0 and error.kind != BROKEN:
                raise
            if not release or attempt == ATTEMPTS or error.kind not in TRANSIENT:
                raise DeployError(f"{error}. {build_status_hint(link.host)}", kind=error.kind) from error
            action = "activate"
    if result.outcome != HEALTHY:
        raise UnhealthyError(
            _format_failure(link.host, result),
            release=result.release,
            outcome=result.outcome,
            current=result.current,
            lines=tuple(result.lines),
        )
    step.finish(f"{result.release} is healthy; {'it runs' if result.is_running else result.reason}")
    return result.release


def build_status_hint(host: RobotAddress) -> str:
    """Return a sentence that says that the check continues, with the command that shows its result."""
    return f"The health check continues on the robot: {host.format_command('status')}"


def _format_failure(host: RobotAddress, result: HealthAnswer) -> str:
    what = "is not healthy" if result.outcome == UNHEALTHY else "was not checked to the end"
    how = "is stopped, as before" if result.is_stopped else "does not run either"
    now = f"{result.current} {'runs again' if result.is_running else f'is the current release again, and {how}'}"
    lines = "".join(f"\n  {line}" for line in result.lines)
    error = next((line.removeprefix(ERROR_PREFIX) for line in result.lines if line.startswith(ERROR_PREFIX)), "")
    remedy = ". Add it to dependencies in pyproject.toml" if NO_MODULE in error else ""
    why = f"{result.reason}: {error.rstrip('.')}{remedy}" if error else result.reason
    running = now if result.current else "No app runs"
    return f"{host}: {result.release} {what}: {why}. {running}. The whole log: {host.format_command('logs')}{lines}"
