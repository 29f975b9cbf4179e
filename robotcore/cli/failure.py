"""How a command tells what went wrong."""

from __future__ import annotations

import click

from robotcore.errors import BehaviourError, DescriptionError, Interrupted, RobotcoreError


def tell(fault: str) -> None:
    """Say on stderr what went wrong."""
    click.echo(click.style("error: ", fg="red", bold=True) + fault, err=True)


def tell_error(error: RobotcoreError | Interrupted) -> None:
    """Say on stderr what was raised; where an app's own code did, after its traceback. Each fault of a file is one."""
    if isinstance(error, BehaviourError):
        click.echo(error.traceback, err=True, nl=False)
    faults = str(error).split("\n") if isinstance(error, DescriptionError) else [str(error)]
    for fault in faults:
        tell(fault)


def usage_fault(error: click.ClickException) -> str:
    """Return what was wrong with the arguments, and where they are explained."""
    context = getattr(error, "ctx", None)
    command = context.command_path if context else "robotcore"
    return f"{error.format_message()}\nTry '{command} --help'."
