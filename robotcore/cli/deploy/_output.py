"""Output of the commands of ``robotcore deploy``: the steps of a job and the state of a robot."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from robotcore.cli.output import write_line
from robotcore.deploy.progress import Progress

if TYPE_CHECKING:
    from rich.live import Live
    from rich.spinner import Spinner

    from robotcore.deploy.answers import State
    from robotcore.deploy.host import Host


class StepDisplay:
    """Prints each finished step, and shows the running one in a line that moves. ``step`` is the newest step.

    The line does not move before the first update of a step: ssh may be asking for a password.
    """

    def __init__(self) -> None:
        self.step = ""
        self._live = _make_live() if sys.stderr and sys.stderr.isatty() else None

    def __call__(self, progress: Progress) -> None:
        self.step = progress.step
        if self._live and progress.text and not progress.is_done:
            self._live.update(_make_spinner(progress))
            self._live.start()
        else:
            self.close()
        if progress.is_done:
            write_line(str(progress))

    def close(self) -> None:
        """Remove the moving line. A second call does nothing."""
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


def _make_spinner(progress: Progress) -> Spinner:
    from rich.spinner import Spinner
    from rich.text import Text

    return Spinner("dots", Text(f"{progress.step:<13}{progress.text}"))  # of a string, rich would obey its markup


GOOD_STATES = ("running", "ended")
"""The states of a release that works."""


def state_exit_status(state: State) -> int:
    """Return 0 if the release runs or has ended with success, else 1."""
    return 0 if state.state in GOOD_STATES else 1


def write_state(host: Host, ssh_config: Path | None, state: State) -> None:
    """Print the state of a robot."""
    for line in format_state(host, ssh_config, state):
        write_line(line)


def format_state(host: Host, ssh_config: Path | None, state: State) -> Iterator[str]:
    """Yield the lines on the state of a robot: what runs, then warnings."""
    from robotcore.deploy.agent.files import format_bytes
    from robotcore.deploy.host import command_hint

    if state.release is None:
        yield f"{host}: {_format_empty_robot(state)}. {command_hint('push', host, ssh_config)}"
        return
    yield f"{host}: {_format_release(state)}"
    if state.on_trial:
        yield _format_row("on trial", f"{state.on_trial}; if it does not live, the release before runs again")
    if state.words:
        yield _format_row("says", state.words)
    if state.reason:
        yield _format_row("restarted" if state.state in GOOD_STATES else "failed", state.reason)
        yield from (f"    {line}" for line in state.lines)
    recorded = state.recordings
    yield _format_row(
        "recordings", f"{recorded.files}, {format_bytes(recorded.bytes)}; {format_bytes(state.free_bytes)} free"
    )
    yield from _format_warnings(state, command_hint("start", host, ssh_config))


def _format_empty_robot(state: State) -> str:
    from robotcore.deploy.health import UNHEALTHY

    if state.on_trial:
        return f"{state.on_trial} is on trial, and no release before it is there"
    if last := state.last:
        what = "did not live" if last.outcome == UNHEALTHY else "is not in place"
        return f"{last.name} {what} ({last.reason or last.outcome}); nothing runs"
    return "nothing was put there yet"


def _format_release(state: State) -> str:
    since = f" for {format_duration(state.for_s)}" if state.for_s is not None else ""
    times = "once" if state.restarts == 1 else f"{state.restarts} times"
    again = f", restarted {times}" if state.restarts else ""
    return f"{state.release} {state.state}{since}{again}"


def _format_warnings(state: State, start: str) -> Iterator[str]:
    if not state.lingers:
        yield _format_row("warning", "it ends with the last login. On the robot: sudo loginctl enable-linger")
    if not state.starts_with_robot:
        yield _format_row("note", f"it does not start with the robot: {start}")


def _format_row(name: str, said: str) -> str:
    return f"  {name:<13}{said}"


def format_duration(seconds: float) -> str:
    """Return a time in the two largest units that it has.

    >>> format_duration(3 * 3600 + 62)
    '3 h 1 min'
    """
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    counts = {"d": days, "h": hours, "min": minutes, "s": rest}
    return " ".join([f"{count} {unit}" for unit, count in counts.items() if count][:2]) or "0 s"
