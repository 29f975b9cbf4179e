"""``robotcore deploy remove``: remove everything that was deployed to a robot."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import DeployCommand, make_link, robot_arguments
from robotcore.cli.output import write_line
from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress


@click.command("remove", cls=DeployCommand)
@robot_arguments
@click.option("--recordings", is_flag=True, help="Remove the recordings too.")
@click.option("--yes", is_flag=True, help="Do not ask for confirmation.")
def command(host: RobotAddress, ssh_config: Path | None, *, recordings: bool, yes: bool) -> int:
    """Stop the app on HOST and remove all that was deployed; keep the recordings unless --recordings."""
    from robotcore.deploy.host import command_hint
    from robotcore.deploy.robot_answers import RemoveAnswer

    what = "all releases and all recordings" if recordings else "all releases, but not the recordings"
    if not yes and not _confirm(f"Stop {host}, and remove {what}?"):
        write_line("Nothing was removed")
        return 1
    with make_link(host, ssh_config) as link:
        kept = link.call("remove", RemoveAnswer, keeps_recordings=not recordings).kept
    note = f". The recordings are still there: {command_hint('fetch', host, ssh_config)}" if kept else ""
    write_line(f"{host}: robotcore was removed{note}")
    return 0


def _confirm(question: str) -> bool:
    if not sys.stdin.isatty():
        raise UsageError(
            "remove asks for confirmation, but stdin is not a terminal. To remove without a question: --yes",
            kind="no-terminal",
        )
    return click.confirm(question, err=True)
