"""Follow the health check of a release; it runs on the robot, and may outlast a connection."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotcore.deploy.answers import Judgement, Notice
from robotcore.deploy.errors import BROKEN
from robotcore.deploy.host import Host, command_hint
from robotcore.deploy.progress import Step, Tell, begin
from robotcore.deploy.rpc import Link
from robotcore.errors import DeployError, UnhealthyError, UsageError
from robotcore.hal.wall_clock import MonotonicClock

STEP = "release"
HEALTHY_WITHIN_S = 60.0
"""A release has so long for its first tick: a Pi imports NumPy and OpenCV, and its camera settles."""

ATTEMPTS, PAUSE_S = 10, 3.0
"""So often a broken connection is made anew, with a pause before each."""

ERROR, NO_MODULE = "error: ", "ModuleNotFoundError: "
"""What stands before an error in what robotcore writes, and in one where something is not installed."""

HEALTHY, UNHEALTHY = "healthy", "unhealthy"
NAME = "name"
"""The kind of a DeployError that tells of a release that is not there."""


def rollback(host: Host, ssh_config: Path | None, release: str | None, tell: Tell = print) -> str:
    """Let the healthy release before run again, or a named one; return its name.

    Raises as `Trial.follow` does, and UsageError where no release has that name.
    """
    with Link(host, ssh_config) as link:
        trial = Trial(host, ssh_config, begin(STEP, tell))
        try:
            return trial.follow(link, "rollback", release=release, healthy_within_s=HEALTHY_WITHIN_S)
        except DeployError as error:
            if error.kind == NAME:
                raise UsageError(str(error)) from error
            raise


@dataclass
class Trial:
    """A trial that a desk looks on. ``release`` is what is tried; the robot tells which one that is, where it chose."""

    host: Host
    ssh_config: Path | None
    step: Step
    release: str | None = None

    def follow(self, link: Link, action: str, release: str | None, **told: Any) -> str:
        """Let the robot try a release, and tell how it does; return its name once it lives.

        Raises UnhealthyError where it does not, and DeployError where that is not known.
        """
        self.release = release
        try:
            came = link.call(action, Judgement, on_say=self._hear, release=release, **told)
        except DeployError as error:
            if error.kind != BROKEN:
                raise
            came = self._found_again(error, told)
        return self._judged(came)

    def _hear(self, notice: Notice) -> None:
        self.release = notice.release or self.release
        self.step.say(notice.say)

    def _found_again(self, broken: DeployError, told: Mapping[str, Any]) -> Judgement:
        """Connect until the robot has told what came of a release that is known by name."""
        clock = MonotonicClock()
        for _ in range(ATTEMPTS if self.release else 0):
            self.step.say("the connection broke; the trial goes on there, and is looked for")
            clock.sleep_until(clock.now() + PAUSE_S)
            try:
                with Link(self.host, self.ssh_config) as link:
                    return link.call("activate", Judgement, on_say=self._hear, release=self.release, **told)
            except DeployError as error:
                broken = error
        raise DeployError(f"{broken}. {goes_on(self.host, self.ssh_config)}", kind=broken.kind) from broken

    def _judged(self, came: Judgement) -> str:
        if came.outcome != HEALTHY:
            logs = command_hint("logs", self.host, self.ssh_config)
            raise UnhealthyError(_unhealthy(self.host, came, logs))
        self.step.done(f"{came.release} is healthy; {'it runs' if came.is_running else came.reason}")
        return came.release


def goes_on(host: Host, ssh_config: Path | None) -> str:
    """Say what a desk that looks away leaves behind."""
    return f"The trial goes on there: {command_hint('status', host, ssh_config)}"


def _unhealthy(host: Host, came: Judgement, logs: str) -> str:
    """Say what came of a release that does not live, in the app's own last words too: first what it ended with."""
    what = "did not live" if came.outcome == UNHEALTHY else "was not judged"
    how = "stands as before" if came.is_standing else "does not run either"
    now = f"{came.current} {'runs again' if came.is_running else f'is in place again, and {how}'}"
    lines = "".join(f"\n  {line}" for line in came.lines)
    why = ": ".join([came.reason, *_error_in(came.lines)])
    return (
        f"{host}: {came.release} {what}: {why}. {now if came.current else 'Nothing runs'}. All it said: {logs}{lines}"
    )


def _error_in(lines: Sequence[str]) -> list[str]:
    """Return the first error that robotcore told of, as far as there is one, and what to do where that is known."""
    errors = [line.removeprefix(ERROR) for line in lines if line.startswith(ERROR)]
    remedy = ". Add it to dependencies in pyproject.toml" if any(NO_MODULE in error for error in errors[:1]) else ""
    return [error.rstrip(".") + remedy for error in errors[:1]]
