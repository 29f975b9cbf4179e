"""Output of the commands of ``robotcore deploy``: the steps of a push and the state of a robot."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from robotcore.cli.output import write_line
from robotcore.deploy.progress import StepProgress

if TYPE_CHECKING:
    from rich.live import Live
    from rich.spinner import Spinner

    from robotcore.deploy.host import RobotAddress
    from robotcore.deploy.robot_answers import StatusAnswer


class StepDisplay:
    """Prints each finished step. If stderr is a terminal, a spinner shows the running step.

    The spinner starts with the first update of a step, because ssh may ask for a password before that.
    """

    def __init__(self) -> None:
        self.step = ""
        """The name of the newest step."""
        self._live = _make_live() if sys.stderr and sys.stderr.isatty() else None

    def __call__(self, progress: StepProgress) -> None:
        self.step = progress.step
        if self._live and progress.text and not progress.is_done:
            self._live.update(_make_spinner(progress))
            self._live.start()
        else:
            self.close()
        if progress.is_done:
            write_line(str(progress))

    def close(self) -> None:
        """Remove the spinner. The method may be called again."""
        if self._live:
            self._live.stop()

    def __enter__(self) -> StepDisplay:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()


def _make_live() -> Live:
    from rich.console import Console
    from rich.live import Live

    return Live(console=Console(stderr=True, highlight=False, markup=False), transient=True)


def _make_spinner(progress: StepProgress) -> Spinner:
    from rich.spinner import Spinner
    from rich.text import Text

    # in a plain string, rich would interpret square brackets as markup
    return Spinner("dots", Text(f"{progress.step:<13}{progress.text}"))


NO_RELEASE = "no release is on the robot"

GOOD_STATES = ("running", "ended")
"""The states of an app that is healthy: it runs, or it has ended with success."""


def choose_exit_status(state: StatusAnswer) -> int:
    """Return 0 if the app runs or has ended with success, else 1."""
    return 0 if state.state in GOOD_STATES else 1


def write_state(host: RobotAddress, ssh_config: Path | None, state: StatusAnswer) -> None:
    """Print the state of a robot."""
    for line in format_state(host, ssh_config, state):
        write_line(line)


def format_state(host: RobotAddress, ssh_config: Path | None, state: StatusAnswer) -> Iterator[str]:
    """Yield the lines of a status report: the current release, its app, and warnings."""
    from robotcore.deploy.agent.files import format_bytes
    from robotcore.deploy.host import command_hint

    if state.release is None:
        yield f"{host}: {_format_empty_robot(state)}. {command_hint('push', host, ssh_config)}"
        return
    yield f"{host}: {_format_release(state)}"
    if state.pending:
        yield _format_row("checking", f"{state.pending}; if it is not healthy, the release before it runs again")
    if state.status_text:
        yield _format_row("status", state.status_text)
    if state.reason:
        yield _format_row("restarted" if state.state in GOOD_STATES else "failed", state.reason)
        yield from (f"    {line}" for line in state.lines)
    recorded = state.recordings
    yield _format_row(
        "recordings", f"{recorded.files}, {format_bytes(recorded.bytes)}; {format_bytes(state.free_bytes)} free"
    )
    yield from _format_warnings(state, command_hint("start", host, ssh_config))


def _format_empty_robot(state: StatusAnswer) -> str:
    from robotcore.deploy.agent.releases import UNHEALTHY

    if state.pending:
        return f"the health check of {state.pending} is running, and the robot has no release before it"
    if last := state.last:
        what = "is not healthy" if last.outcome == UNHEALTHY else "is not the current release"
        return f"{last.name} {what} ({last.reason or last.outcome}); no app runs"
    return NO_RELEASE


def _format_release(state: StatusAnswer) -> str:
    since = f" for {format_duration(state.for_s)}" if state.for_s is not None else ""
    times = "once" if state.restarts == 1 else f"{state.restarts} times"
    again = f", restarted {times}" if state.restarts else ""
    return f"{state.release} {state.state}{since}{again}"


def _format_warnings(state: StatusAnswer, start: str) -> Iterator[str]:
    if not state.lingers:
        yield _format_row("warning", "the app ends with the last login. On the robot: sudo loginctl enable-linger")
    if not state.starts_with_robot:
        yield _format_row("note", f"the app does not start with the robot: {start}")


def _format_row(name: str, text: str) -> str:
    return f"  {name:<13}{text}"


def format_duration(seconds: float) -> str:
    """Return a time in words, with its two largest units.

    >>> format_duration(3 * 3600 + 62)
    '3 h 1 min'
    """
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    counts = {"d": days, "h": hours, "min": minutes, "s": rest}
    return " ".join([f"{count} {unit}" for unit, count in counts.items() if count][:2]) or "0 s"
