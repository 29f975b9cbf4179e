"""``robotcore deploy remove``: a robot as it was before the first push."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy.target import DeployCommand, link_to, on_robot

if TYPE_CHECKING:
    from robotcore.deploy.host import Host


@click.command("remove", cls=DeployCommand)
@on_robot
@click.option("--recordings", is_flag=True, help="The recordings too.")
@click.option("--yes", is_flag=True, help="Do not ask.")
def command(host: Host, ssh_config: Path | None, *, recordings: bool, yes: bool) -> int:
    """Stop the app on HOST and take away all that was put there; recordings stay, unless --recordings."""
    what = "all releases and all recordings" if recordings else "all releases; the recordings stay"
    if not yes:
        click.confirm(f"Stop {host}, and take away {what}?", abort=True, err=True)
    with link_to(host, ssh_config) as link:
        link.call("remove", keeps_recordings=not recordings)
    click.echo(f"{host}: {what if recordings else 'all releases are gone; the recordings stay'}")
    return 0
