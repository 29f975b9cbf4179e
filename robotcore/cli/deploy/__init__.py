"""``robotcore deploy``: put a project on a robot and keep it running there."""

from __future__ import annotations

import click

from robotcore.cli.command_classes import LazyGroup
from robotcore.cli.output import write_lines


@click.group(
    "deploy",
    cls=LazyGroup,
    package="robotcore.cli.deploy",
    commands=(
        "push",
        "list",
        "releases:rollback",
        "app:status",
        "app:logs",
        "view",
        "app:start",
        "app:stop",
        "releases:remove",
        "fetch",
    ),
    invoke_without_command=True,
)
@click.pass_context
def command(context: click.Context) -> None:
    """Put a project on a robot and keep it running there.

    HOST is [user@]host[:port], or an alias of your ssh configuration, which applies in full.
    """
    if context.invoked_subcommand is None:
        write_lines(context.get_help())
