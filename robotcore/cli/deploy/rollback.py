"""``robotcore deploy rollback``: run an earlier release again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import DeployCommand, robot_arguments
from robotcore.cli.output import write_lines
from robotcore.errors import Interrupted

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress


def _parse_release(value: str) -> str:
    from robotcore.deploy.agent.releases import require_name

    try:
        return require_name(value)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


@click.command("rollback", cls=DeployCommand)
@robot_arguments
@click.argument("release", required=False, type=_parse_release)
def command(host: RobotAddress, ssh_config: Path | None, release: str | None) -> int:
    """Run the last healthy release before the current one on HOST again, or RELEASE.

    The robot checks its health as after a push. If it is not healthy, the current release runs again. `robotcore deploy
    list` lists the releases.
    """
    from robotcore.cli.deploy._output import StepDisplay
    from robotcore.deploy.health_progress import STEP, rollback, status_hint

    with StepDisplay() as display:
        try:
            rollback(host, ssh_config, release, display)
        except Interrupted:
            display.close()
            if display.step == STEP:
                write_lines(status_hint(host, ssh_config), is_error=True)
            raise
    return 0
