"""``robotcore deploy rollback``: a release that was there before runs again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy.target import DeployCommand, on_robot
from robotcore.errors import Interrupted

if TYPE_CHECKING:
    from robotcore.deploy.host import Host


@click.command("rollback", cls=DeployCommand)
@on_robot
@click.argument("release", required=False)
def command(host: Host, ssh_config: Path | None, release: str | None) -> int:
    """Let the healthy release before run on HOST again, or RELEASE.

    It is tried as after a push: where it does not live, the one that ran goes on. `robotcore deploy list` names those
    that are there.
    """
    from robotcore.cli.deploy.showing import Showing
    from robotcore.deploy.trial import goes_on, rollback

    with Showing() as showing:
        try:
            rollback(host, ssh_config, release, showing)
        except Interrupted:
            showing.close()
            click.echo(goes_on(host), err=True)
            raise
    return 0
