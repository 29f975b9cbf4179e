"""How a command tells what went wrong."""

from __future__ import annotations

import click

from robotcore.cli.output import INDENT, write_line, write_lines
from robotcore.errors import BehaviourError, DescriptionError, Interrupted, RobotcoreError
from robotcore.text import escape


def tell(fault: str) -> None:
    """Say on stderr what went wrong; what follows its first line is indented."""
    first, *others = fault.split("\n")
    write_line(f"{click.style('error:', fg='red', bold=True)} {escape(first)}", is_error=True, is_styled=True)
    for line in others:
        write_line(f"{INDENT}{line}", is_error=True)


def tell_error(error: RobotcoreError | Interrupted) -> None:
    """Say on stderr what was raised; where an app's own code did, after its traceback. Each fault of a file is one."""
    if isinstance(error, BehaviourError) and error.traceback:
        write_lines(error.traceback.rstrip("\n"), indent=INDENT, is_error=True)
    faults = str(error).split("\n") if isinstance(error, DescriptionError) else [str(error)]
    for fault in faults:
        tell(fault)


def tell_usage(error: click.ClickException) -> None:
    """Say on stderr what was wrong with the arguments, and where they are explained."""
    context = getattr(error, "ctx", None)
    tell(error.format_message())
    write_line(f"Try '{context.command_path if context else 'robotcore'} --help'.", is_error=True)
