"""``robotcore deploy fetch``: what a robot recorded comes home."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy.showing import Showing
from robotcore.cli.deploy.target import DeployCommand, link_to, on_robot
from robotcore.cli.values import Folder

if TYPE_CHECKING:
    from robotcore.deploy.connection.host import Host
    from robotcore.deploy.fetch import Fetched

RECORDINGS = Path("recordings")
"""Here, with a folder for each robot."""


@click.command("fetch", cls=DeployCommand)
@on_robot
@click.option("-o", "--out", metavar="DIR", type=Folder(), help="Where to; recordings/HOST if left out.")
@click.option("--move", "moves", is_flag=True, help="Delete there what is here, byte for byte.")
def command(host: Host, ssh_config: Path | None, out: Path | None, *, moves: bool) -> int:
    """Bring the recordings of HOST here: those that are not here yet.

    No file here is overwritten by another one; a recording that is being written stays there. Exit status 1 where
    something here has a recording's name and another content.
    """
    from robotcore.deploy.fetch import fetch

    with Showing() as showing, link_to(host, ssh_config) as link:
        fetched = fetch(link, out or RECORDINGS / host.name, showing, moves=moves)
    _tell_what_next(fetched)
    return 1 if fetched.different else 0


def _tell_what_next(fetched: Fetched) -> None:
    from robotcore.deploy.paths import told

    if fetched.newest:
        file = shlex.quote(told(fetched.newest))
        click.echo(f"Replay the newest: robotcore replay {file}")
        click.echo(f"Compare it with a simulated run: robotcore compare {file} run.mcap")
