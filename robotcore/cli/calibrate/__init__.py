"""``robotcore calibrate``: measure the parts of a robot, and correct its file."""

from __future__ import annotations

import click

from robotcore.cli.command_classes import LazyGroup
from robotcore.cli.output import write_lines


@click.group(
    "calibrate",
    cls=LazyGroup,
    package="robotcore.cli.calibrate",
    commands=("motors", "drive", "camera", "range"),
    invoke_without_command=True,
)
@click.pass_context
def command(context: click.Context) -> None:
    """Measure the parts of a robot, and correct its file.

    Without --write, a command prints the changes and leaves the file as it is. An e-stop, Ctrl-C or an error ends a
    command. Complete results are then still shown and written.
    """
    if context.invoked_subcommand is None:
        write_lines(context.get_help())
