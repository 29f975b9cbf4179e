"""The command ``robotcore``: its subcommands, and the exit status of each error."""

from __future__ import annotations

import atexit
import io
import os
import signal
import sys
import threading
from collections.abc import Sequence
from types import FrameType
from typing import NoReturn, TextIO

import click

from robotcore.cli.command_classes import LazyGroup
from robotcore.cli.output import write_error, write_failure, write_line, write_lines, write_usage_error
from robotcore.errors import Interrupted, RobotcoreError
from robotcore.system import HAS_POSIX

__all__ = ["execute", "run_app"]

SIGNAL_BASE = 128
"""The exit status of a process that signal n ended is this plus n."""

INTERRUPTED = SIGNAL_BASE + 2
"""The exit status after SIGINT."""

EXITING_S = 3.0
"""The time that the interpreter has to exit, in seconds. After it, the process ends at once."""

OUTPUT_FAILED = 1
"""The exit status if the output cannot be written."""


@click.group(
    cls=LazyGroup,
    package="robotcore.cli",
    commands=(
        "scaffold:new",
        "run",
        "teleop",
        "sweep",
        "recordings:replay",
        "recordings:compare",
        "recordings:info",
        "fidelity",
        "view",
        "run:demo",
        "lists:apps",
        "lists:backends",
        "lists:faults",
        "lists:kinds",
        "lists:robots",
        "lists:worlds",
        "descriptions:check",
        "descriptions:export",
        "wiring",
        "calibrate",
        "doctor",
        "test-devices",
        "firmware",
        "deploy",
        "stop",
    ),
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=lambda context, _option, is_given: _write_version(context) if is_given else None,
    help="Show the version and exit.",
)
@click.pass_context
def robotcore(context: click.Context) -> None:
    """Write a robot's behaviour once, and run the same file in simulation and on the robot."""
    if context.invoked_subcommand is None:
        write_lines(context.get_help())


def _write_version(context: click.Context) -> NoReturn:
    from robotcore.compatibility import read_version

    write_line(f"robotcore {read_version()}")
    context.exit()


def main() -> NoReturn:
    """Run the command line of this process, and exit with its status."""
    _open_closed_streams()
    _allow_all_characters()
    _exit(execute(sys.argv[1:]))


def run_app(name: str) -> NoReturn:
    """Run an app with this process's arguments, as ``robotcore run NAME`` does, and exit.

    An app's file calls this function, so that ``python FILE`` runs the app.

    name: the app's name or file, as for ``robotcore run``.

    >>> from robotcore.cli.main import __file__
    >>> if __name__ == "__main__":  # the last lines of an app's file
    ...     run_app(__file__)
    """
    _open_closed_streams()
    _allow_all_characters()
    _exit(execute(["run", name, *sys.argv[1:]]))


def _open_closed_streams() -> None:
    """Open the null device for each closed standard stream. Otherwise a serial port could get the number of stdout."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            file = os.open(os.devnull, os.O_RDWR)  # gets the lowest free number, which is that of the closed stream
            os.set_inheritable(file, True)
            setattr(sys, name, os.fdopen(file, "w" if number else "r"))


def _allow_all_characters() -> None:
    """Let stdout replace the characters that its encoding lacks, such as that of a pipe on Windows, by ``?``."""
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.encoding.lower() not in ("utf-8", "utf8"):
        sys.stdout.reconfigure(errors="replace")


def execute(arguments: Sequence[str]) -> int:
    """Run one command, and return its exit status. If signal n ended the command, the status is 128 + n.

    A RobotcoreError and an invalid argument are reported on stderr. Any other exception is raised.

    arguments: the words of the command line after ``robotcore``.

    >>> execute(["worlds", "--no-such-option"])
    2
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
        return OUTPUT_FAILED
    return status or 0


def _exit(status: int) -> NoReturn:
    """Flush the output and exit with a status. If a signal ended the command, end the process by the same signal."""
    if not _flush(sys.stdout):
        status = status or OUTPUT_FAILED
    _flush(sys.stderr)
    if status > SIGNAL_BASE:
        from robotcore.runtime.signals import end_by_signal

        end_by_signal(status - SIGNAL_BASE)
    _limit_exit(status)
    sys.exit(status)


def _limit_exit(status: int) -> None:
    """End the process if threads still run after `EXITING_S` seconds. Python itself would wait for them forever.

    The limit does not hold for the time after the last thread, in which Python frees its objects: then the signal of
    the timer would end the process with another status.
    """

    def end(_number: int, _frame: FrameType | None) -> NoReturn:
        own = (threading.main_thread(), threading.current_thread())
        names = [thread.name for thread in threading.enumerate() if thread not in own]
        write_line(f"note: the process ends while threads still run: {', '.join(names)}", is_error=True)
        os._exit(status)

    if HAS_POSIX:
        atexit.register(signal.setitimer, signal.ITIMER_REAL, 0.0)  # Python calls this after the last thread
        signal.signal(signal.SIGALRM, end)
        signal.setitimer(signal.ITIMER_REAL, EXITING_S)
    else:
        timer = threading.Timer(EXITING_S, end, (0, None))
        timer.daemon = True
        atexit.register(timer.cancel)
        timer.start()


def _flush(stream: TextIO | None) -> bool:
    """Return whether a stream could be flushed. If not, discard its output, so that Python's own flush succeeds."""
    if stream is None:
        return True
    try:
        stream.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        return False
    return True
