"""``robotcore deploy start``: start the app on a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import DeployCommand, make_link, robot_arguments
from robotcore.cli.deploy._output import choose_exit_status, write_state

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress


@click.command("start", cls=DeployCommand)
@robot_arguments
def command(host: RobotAddress, ssh_config: Path | None) -> int:
    """Start the release on HOST, now and each time the robot is switched on."""
    from robotcore.deploy.robot_answers import StatusAnswer

    with make_link(host, ssh_config) as link:
        state = link.call("start", StatusAnswer)
    write_state(host, ssh_config, state)
    return choose_exit_status(state)
