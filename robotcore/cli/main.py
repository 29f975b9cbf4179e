"""The command ``robotcore``: its commands, and how whatever ends one becomes an exit status."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Sequence
from types import FrameType
from typing import NoReturn, TextIO

import click

from robotcore.cli.lazy_group import LazyGroup
from robotcore.cli.output import write_error, write_failure, write_line, write_lines, write_usage_error
from robotcore.errors import Interrupted, RobotcoreError

SIGNALLED = 128
"""A status above this one stands for the signal of the number that is left."""

INTERRUPTED = SIGNALLED + 2
"""By SIGINT."""

EXITING_S = 3.0

UNWRITTEN = 1
"""The output could not be written."""


@click.group(
    cls=LazyGroup,
    package="robotcore.cli",
    names=(
        "new",
        "run",
        "sweep",
        "replay",
        "compare",
        "info",
        "demo",
        "apps",
        "backends",
        "faults",
        "robots",
        "worlds",
        "check",
        "export",
        "wiring",
        "doctor",
        "firmware",
        "deploy",
        "stop",
    ),
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(package_name="robotcore", prog_name="robotcore", message="%(prog)s %(version)s")
@click.pass_context
def robotcore(context: click.Context) -> None:
    """Write a robot's behaviour once; run the same file in simulation and on the robot."""
    if context.invoked_subcommand is None:
        write_lines(context.get_help())


def main() -> NoReturn:
    """Run the command line of this process, and exit."""
    _exit(execute(sys.argv[1:]))


def run_app(name: str) -> NoReturn:
    """Run an app as ``robotcore run NAME`` with this process's arguments, and exit: ``python -m`` on its file."""
    _exit(execute(["run", name, *sys.argv[1:]]))


def execute(arguments: Sequence[str]) -> int:
    """Run one command; return its exit status, 128 + n after the signal n.

    Expected errors are written in a line or two on stderr.
    """
    try:
        status: int | None = robotcore.main(list(arguments), "robotcore", standalone_mode=False)
    except click.ClickException as error:
        write_usage_error(error)
        return error.exit_code
    except (RobotcoreError, Interrupted) as error:
        write_error(error)
        return error.exit_status
    except click.Abort:
        return INTERRUPTED
    except OSError as error:
        write_failure(f"the output cannot be written: {error.strerror}")
        return UNWRITTEN
    return status or 0


def _exit(status: int) -> NoReturn:
    """Exit, or die of the signal that the status stands for, with what was written in safety."""
    if not _flushed(sys.stdout):
        status = status or UNWRITTEN
    _flushed(sys.stderr)
    if status > SIGNALLED:
        from robotcore.runtime.signals import die_of

        die_of(status - SIGNALLED)
    _limit_exit(status)
    sys.exit(status)


def _limit_exit(status: int) -> None:
    """End the process in `EXITING_S`: the interpreter waits without a limit for threads that an app has left."""

    def end(_number: int, _frame: FrameType | None) -> NoReturn:
        names = [thread.name for thread in threading.enumerate() if thread is not threading.main_thread()]
        write_line(f"note: the process ends with threads that still run: {', '.join(names)}", is_error=True)
        os._exit(status)

    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, end)
        signal.setitimer(signal.ITIMER_REAL, EXITING_S)


def _flushed(stream: TextIO | None) -> bool:
    """Return whether what was printed got out; where it cannot, the interpreter must not try again."""
    if stream is None:
        return True
    try:
        stream.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        return False
    return True
