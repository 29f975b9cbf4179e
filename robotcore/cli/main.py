"""The command ``robotcore``: its commands, and how whatever ends one becomes an exit status."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import NoReturn

import click

from robotcore.cli.failure import tell, tell_error, usage_fault
from robotcore.cli.lazy import LazyGroup
from robotcore.errors import Interrupted, RobotcoreError

INTERRUPTED = 130
"""128 + SIGINT."""

UNWRITTEN = 1
"""The output could not be written."""


@click.group(
    cls=LazyGroup,
    package="robotcore.cli",
    names=("run", "sweep", "demo", "apps", "backends", "robots", "worlds", "check", "export"),
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(package_name="robotcore", prog_name="robotcore", message="%(prog)s %(version)s")
@click.pass_context
def robotcore(context: click.Context) -> None:
    """Write a robot's behaviour once; run the same file in simulation and on the robot."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main() -> NoReturn:
    """Run the command line of this process, and exit."""
    _exit(execute(sys.argv[1:]))


def run_app(name: str) -> NoReturn:
    """Run an app as ``robotcore run NAME`` with this process's arguments, and exit: ``python -m`` on its file."""
    _exit(execute(["run", name, *sys.argv[1:]]))


def execute(arguments: Sequence[str]) -> int:
    """Run one command; return its exit status. What can be expected is told in a line or two on stderr."""
    try:
        status: int | None = robotcore.main(list(arguments), "robotcore", standalone_mode=False)
    except click.ClickException as error:
        tell(usage_fault(error))
        return error.exit_code
    except (RobotcoreError, Interrupted) as error:
        tell_error(error)
        return error.exit_status
    except click.Abort:
        return INTERRUPTED
    except OSError as error:
        tell(f"the output cannot be written: {error.strerror}")
        return UNWRITTEN
    return status or 0


def _exit(status: int) -> NoReturn:
    """Exit, with what was written in safety; where it cannot be, the interpreter must not try again."""
    try:
        if sys.stdout:
            sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = status or UNWRITTEN
    sys.exit(status)
