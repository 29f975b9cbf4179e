"""How a command tells what went wrong."""

from __future__ import annotations

import click


def tell(fault: str) -> None:
    """Say on stderr what went wrong."""
    click.echo(click.style("error: ", fg="red", bold=True) + fault, err=True)


def usage_fault(error: click.ClickException) -> str:
    """Return what was wrong with the arguments, and where they are explained."""
    context = getattr(error, "ctx", None)
    command = context.command_path if context else "robotcore"
    return f"{error.format_message()}\nTry '{command} --help'."
