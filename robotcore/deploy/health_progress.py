"""Follow the health check of a release from the client.

The check runs on the robot, and goes on if the connection breaks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotcore.deploy.errors import BROKEN
from robotcore.deploy.host import Host, command_hint
from robotcore.deploy.progress import OnStep, Step, begin_step
from robotcore.deploy.robot_answers import HealthResult, Notice
from robotcore.deploy.rpc import Link
from robotcore.errors import DeployError, UnhealthyError, UsageError
from robotcore.hal.wall_clock import MonotonicClock

STEP = "release"
"""The name of the step in progress reports."""

HEALTHY_WITHIN_S = 60.0
"""The time within which the app must complete its first tick, in s.

It is long because a Pi needs time to import NumPy and OpenCV, and to let its camera settle.
"""

ATTEMPTS, PAUSE_S = 10, 3.0
"""The number of attempts to connect again after the connection broke, and the pause before each attempt in s."""

ERROR_PREFIX, NO_MODULE = "error: ", "ModuleNotFoundError: "
"""The beginning of each error message of robotcore, and the text that the message contains if a package is missing."""

RECONNECTING = "the connection broke; connecting again, while the health check continues on the robot"

HEALTHY, UNHEALTHY = "healthy", "unhealthy"
"""The outcomes of a health check that the client distinguishes, see `robotcore.deploy.agent.releases.HEALTHY`."""

UNKNOWN_RELEASE = "name"
"""The kind of a DeployError if the robot has no release of that name."""


def rollback(host: Host, ssh_config: Path | None, release: str | None, on_step: OnStep = print) -> str:
    """Run an older release again, and wait until it is healthy; return its name.

    host: the robot.
    ssh_config: an ssh configuration in place of the user's.
    release: the release's name; None for the newest healthy one that is older than the current one.
    on_step: this function is called with the progress.
    Raises UsageError if the robot has no release of that name, and the errors of `HealthCheck.follow`.
    """
    with Link(host, ssh_config) as link:
        check = HealthCheck(host, ssh_config, begin_step(STEP, on_step))
        try:
            return check.follow(link, "rollback", release=release, healthy_within_s=HEALTHY_WITHIN_S)
        except DeployError as error:
            if error.kind == UNKNOWN_RELEASE:
                raise UsageError(str(error)) from error
            raise


@dataclass
class HealthCheck:
    """Follows a health check that runs on a robot."""

    host: Host
    ssh_config: Path | None
    step: Step
    """The step that reports the progress."""
    release: str | None = None
    """The name of the release that is checked; None until the robot has chosen one."""

    def follow(self, link: Link, action: str, release: str | None, **arguments: Any) -> str:
        """Let the robot check a release, and report the progress; return the name of the healthy release.

        action: ``activate`` or ``rollback``.
        release: the release to check; None if the robot chooses.
        arguments: the other parameters of the action.
        Raises UnhealthyError if the release is not healthy, and DeployError if the client does not get the result.
        """
        self.release = release
        try:
            result = link.call(action, HealthResult, on_notice=self._show_notice, release=release, **arguments)
        except DeployError as error:
            if error.kind != BROKEN:
                raise
            result = self._reconnect(error, arguments)
        return self._finish(result)

    def _show_notice(self, notice: Notice) -> None:
        self.release = notice.release or self.release
        self.step.update(notice.say)

    def _reconnect(self, broken: DeployError, arguments: Mapping[str, Any]) -> HealthResult:
        """Connect again until the robot returns the result.

        If the robot has not yet sent the name of the release, the error is raised without an attempt.
        """
        clock = MonotonicClock()
        for _ in range(ATTEMPTS if self.release else 0):
            self.step.update(RECONNECTING)
            clock.sleep_until(clock.now() + PAUSE_S)
            try:
                with Link(self.host, self.ssh_config) as link:
                    return link.call(
                        "activate", HealthResult, on_notice=self._show_notice, release=self.release, **arguments
                    )
            except DeployError as error:
                broken = error
        raise DeployError(f"{broken}. {status_hint(self.host, self.ssh_config)}", kind=broken.kind) from broken

    def _finish(self, result: HealthResult) -> str:
        if result.outcome != HEALTHY:
            logs = command_hint("logs", self.host, self.ssh_config)
            raise UnhealthyError(
                _format_failure(self.host, result, logs),
                release=result.release,
                outcome=result.outcome,
                current=result.current,
                lines=tuple(result.lines),
            )
        self.step.finish(f"{result.release} is healthy; {'it runs' if result.is_running else result.reason}")
        return result.release


def status_hint(host: Host, ssh_config: Path | None) -> str:
    """Return a sentence for a user who interrupts a health check, with the command that shows its result."""
    return f"The health check continues on the robot: {command_hint('status', host, ssh_config)}"


def _format_failure(host: Host, result: HealthResult, logs: str) -> str:
    """Return the error message for a release that is not healthy.

    It has the reason, the release that is current now, and the last lines of the app's output.
    """
    what = "is not healthy" if result.outcome == UNHEALTHY else "was not checked to the end"
    how = "is stopped, as before" if result.is_standing else "does not run either"
    now = f"{result.current} {'runs again' if result.is_running else f'is the current release again, and {how}'}"
    lines = "".join(f"\n  {line}" for line in result.lines)
    why = ": ".join([result.reason, *_find_error(result.lines)])
    running = now if result.current else "No app runs"
    return f"{host}: {result.release} {what}: {why}. {running}. The whole log: {logs}{lines}"


def _find_error(lines: Sequence[str]) -> list[str]:
    """Return the first error message of robotcore in the lines; empty if there is none.

    If a package is missing, a remedy is added.
    """
    errors = [line.removeprefix(ERROR_PREFIX) for line in lines if line.startswith(ERROR_PREFIX)]
    remedy = ". Add it to dependencies in pyproject.toml" if any(NO_MODULE in error for error in errors[:1]) else ""
    return [error.rstrip(".") + remedy for error in errors[:1]]
