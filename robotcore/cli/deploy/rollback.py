"""``robotcore deploy rollback``: a release that was there before runs again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import DeployCommand, on_robot
from robotcore.cli.output import write_lines
from robotcore.errors import Interrupted

if TYPE_CHECKING:
    from robotcore.deploy.host import Host


def _release(value: str) -> str:
    from robotcore.deploy.agent.releases import require_name

    try:
        return require_name(value)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


@click.command("rollback", cls=DeployCommand)
@on_robot
@click.argument("release", required=False, type=_release)
def command(host: Host, ssh_config: Path | None, release: str | None) -> int:
    """Let the healthy release before run on HOST again, or RELEASE.

    It is tried as after a push: where it does not live, the one that ran goes on. `robotcore deploy list` names those
    that are there.
    """
    from robotcore.cli.deploy._output import Showing
    from robotcore.deploy.health import STEP, goes_on, rollback

    with Showing() as showing:
        try:
            rollback(host, ssh_config, release, showing)
        except Interrupted:
            showing.close()
            if showing.step == STEP:
                write_lines(goes_on(host, ssh_config), is_error=True)
            raise
    return 0
