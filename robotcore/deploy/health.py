"""Follow the health check of a release. It runs on the robot and continues if the connection breaks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotcore.deploy.answers import HealthResult, Notice
from robotcore.deploy.errors import BROKEN
from robotcore.deploy.host import Host, command_hint
from robotcore.deploy.progress import OnStep, Step, begin_step
from robotcore.deploy.rpc import Link
from robotcore.errors import DeployError, UnhealthyError, UsageError
from robotcore.hal.wall_clock import MonotonicClock

STEP = "release"
HEALTHY_WITHIN_S = 60.0
"""A release has so long for its first tick: a Pi imports NumPy and OpenCV, and its camera settles."""

ATTEMPTS, PAUSE_S = 10, 3.0
"""So often a broken connection is made anew, with a pause before each."""

ERROR_PREFIX, NO_MODULE = "error: ", "ModuleNotFoundError: "
"""What stands before an error in what robotcore writes, and in one where something is not installed."""

HEALTHY, UNHEALTHY = "healthy", "unhealthy"
UNKNOWN_RELEASE = "name"
"""The kind of a DeployError that tells of a release that is not there."""


def rollback(host: Host, ssh_config: Path | None, release: str | None, on_step: OnStep = print) -> str:
    """Let the healthy release before run again, or a named one; return its name.

    Raises as `Trial.follow` does, and UsageError where no release has that name.
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
    """A trial that a desk looks on. ``release`` is what is tried; the robot tells which one that is, where it chose."""

    host: Host
    ssh_config: Path | None
    step: Step
    release: str | None = None

    def follow(self, link: Link, action: str, release: str | None, **arguments: Any) -> str:
        """Let the robot try a release, and tell how it does; return its name once it lives.

        Raises UnhealthyError where it does not, and DeployError where that is not known.
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
        """Connect again until the robot returns the result for a release whose name is known."""
        clock = MonotonicClock()
        for _ in range(ATTEMPTS if self.release else 0):
            self.step.update("the connection broke; the trial goes on there, and is looked for")
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
            raise UnhealthyError(_format_failure(self.host, result, logs))
        self.step.finish(f"{result.release} is healthy; {'it runs' if result.is_running else result.reason}")
        return result.release


def status_hint(host: Host, ssh_config: Path | None) -> str:
    """Say what a desk that looks away leaves behind."""
    return f"The trial goes on there: {command_hint('status', host, ssh_config)}"


def _format_failure(host: Host, result: HealthResult, logs: str) -> str:
    """Return the message for a release that is not healthy: the reason, what runs now, and the app's last lines."""
    what = "did not live" if result.outcome == UNHEALTHY else "was not judged"
    how = "stands as before" if result.is_standing else "does not run either"
    now = f"{result.current} {'runs again' if result.is_running else f'is in place again, and {how}'}"
    lines = "".join(f"\n  {line}" for line in result.lines)
    why = ": ".join([result.reason, *_find_error(result.lines)])
    running = now if result.current else "Nothing runs"
    return f"{host}: {result.release} {what}: {why}. {running}. All it said: {logs}{lines}"


def _find_error(lines: Sequence[str]) -> list[str]:
    """Return the first line that is an error of robotcore, with a remedy if one is known."""
    errors = [line.removeprefix(ERROR_PREFIX) for line in lines if line.startswith(ERROR_PREFIX)]
    remedy = ". Add it to dependencies in pyproject.toml" if any(NO_MODULE in error for error in errors[:1]) else ""
    return [error.rstrip(".") + remedy for error in errors[:1]]
