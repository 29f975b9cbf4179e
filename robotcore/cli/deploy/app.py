"""``robotcore deploy status``, ``logs``, ``start`` and ``stop``: commands on the app of a robot."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.deploy._options import AnsweringDeployCommand, DeployCommand, make_link, robot_argument
from robotcore.cli.output import as_json, write_json, write_line
from robotcore.errors import Interrupted

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress
    from robotcore.deploy.robot_answers import StatusAnswer

GOOD_STATES = ("running", "ended")
"""The states of an app that is healthy: it runs, or it has ended with success."""

LINE_BYTES = 1 << 16
"""The greatest length of a log line, in bytes. journald splits lines at 48 kB. Source: journald.conf(5), LineMax."""

OVERHEAD_BYTES = 1 << 20
"""The greatest length of the messages by systemd and journalctl, in bytes, in addition to the app's lines."""


@click.command("status", cls=AnsweringDeployCommand)
@robot_argument
@as_json
def status(host: RobotAddress, *, as_json: bool) -> int:
    """Print the release on HOST, its state, and the time in this state.

    Exit status: 0 it runs or has ended with success, 1 it does not run, 3 the robot cannot be reached.
    """
    state = _call(host, "status")
    exit_status = _choose_exit_status(state)
    if as_json:
        write_json(_build_answer(host, state, exit_status))
    else:
        _write_state(host, state)
    return exit_status


def _build_answer(host: RobotAddress, state: StatusAnswer, exit_status: int) -> dict[str, Any]:
    """Return the JSON answer of ``robotcore deploy status``.

    The JSON keys:

    host: text; the robot's address.
    *: robotcore.deploy.robot_answers.StatusAnswer
    exit_status: whole number; the exit status.
    """
    return {"host": str(host), **state.model_dump(by_alias=True), "exit_status": exit_status}


@click.command("logs", cls=DeployCommand)
@robot_argument
@click.option("-f", "--follow", is_flag=True, help="Print new lines as they come, until Ctrl-C.")
@click.option(
    "-n",
    "--lines",
    metavar="N",
    type=click.IntRange(1),
    default=50,
    show_default=True,
    help="Number of past lines to show.",
)
def logs(host: RobotAddress, lines: int, *, follow: bool) -> int:
    """Print the log of the app on HOST, with systemd's messages about it. Ctrl-C does not stop the app."""
    is_empty = True

    def write_log_line(line: str) -> None:
        nonlocal is_empty
        is_empty = False
        write_line(line)

    try:
        with make_link(host) as link:
            max_bytes = None if follow else OVERHEAD_BYTES + lines * LINE_BYTES
            link.stream("logs", on_line=write_log_line, max_bytes=max_bytes, lines=lines, follow=follow)
    except Interrupted as interruption:
        if not follow:
            raise
        return interruption.exit_status
    if is_empty:
        write_line(f"{host}: the log has no line of an app. {host.format_command('status')}", is_error=True)
    return 0


@click.command("start", cls=DeployCommand)
@robot_argument
def start(host: RobotAddress) -> int:
    """Start the release on HOST, now and each time the robot is switched on."""
    state = _call(host, "start")
    _write_state(host, state)
    return _choose_exit_status(state)


@click.command("stop", cls=DeployCommand)
@robot_argument
def stop(host: RobotAddress) -> int:
    """Stop the app on HOST and every motor; it stays stopped until `robotcore deploy start` or the next push."""
    state = _call(host, "stop")
    if state.release is None:
        write_line(f"{host}: no release is on the robot, so no app runs")
    else:
        _write_state(host, state)
    return 0


def _call(host: RobotAddress, action: str) -> StatusAnswer:
    from robotcore.deploy.robot_answers import StatusAnswer

    with make_link(host) as link:
        return link.call(action, StatusAnswer)


def _choose_exit_status(state: StatusAnswer) -> int:
    return 0 if state.state in GOOD_STATES else 1


def _write_state(host: RobotAddress, state: StatusAnswer) -> None:
    """Print the current release, its app, and warnings."""
    from robotcore.deploy.agent.files import format_bytes

    if state.release is None:
        write_line(f"{host}: {_format_empty_robot(state)}. {host.format_command('push')}")
        return
    since = f" for {format_duration(state.for_s)}" if state.for_s is not None else ""
    times = "once" if state.restarts == 1 else f"{state.restarts} times"
    write_line(f"{host}: {state.release} {state.state}{since}{f', restarted {times}' if state.restarts else ''}")
    room = f"{format_bytes(state.recordings.bytes)}; {format_bytes(state.free_bytes)} free"
    for name, text in (*_describe_app(host, state), ("recordings", f"{state.recordings.files}, {room}")):
        write_line(f"  {name:<13}{text}".rstrip() if name else f"    {text}")
    if not state.lingers:
        write_line("  warning      the app ends with the last login. On the robot: sudo loginctl enable-linger")
    if not state.starts_with_robot:
        write_line(f"  note         the app does not start with the robot: {host.format_command('start')}")


def _describe_app(host: RobotAddress, state: StatusAnswer) -> Iterator[tuple[str, str]]:
    """Yield the name and the text of each line about the app. The name of a line of its output is empty."""
    if state.pending:
        yield "checking", f"{state.pending}; if it is not healthy, the release before it runs again"
    if state.status_text:
        yield "status", state.status_text
    if state.view_port and state.state == "running":
        yield "live page", host.format_command("view")
    if state.reason:
        yield "restarted" if state.state in GOOD_STATES else "failed", state.reason
        yield from (("", line) for line in state.lines)


def _format_empty_robot(state: StatusAnswer) -> str:
    from robotcore.deploy.agent.releases import UNHEALTHY

    if state.pending:
        return f"the health check of {state.pending} is running, and the robot has no release before it"
    if last := state.last:
        what = "is not healthy" if last.outcome == UNHEALTHY else "is not the current release"
        return f"{last.name} {what} ({last.reason or last.outcome}); no app runs"
    return "no release is on the robot"


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
