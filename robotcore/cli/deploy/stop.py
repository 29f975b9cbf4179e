"""``robotcore deploy stop``: stop the app and the motors of a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import DeployCommand, make_link, robot_arguments
from robotcore.cli.deploy._output import write_state
from robotcore.cli.output import write_line

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress


@click.command("stop", cls=DeployCommand)
@robot_arguments
def command(host: RobotAddress, ssh_config: Path | None) -> int:
    """Stop the app on HOST and every motor; it stays stopped until `robotcore deploy start` or the next push."""
    from robotcore.deploy.robot_answers import StatusAnswer

    with make_link(host, ssh_config) as link:
        state = link.call("stop", StatusAnswer)
    if state.release is None:
        write_line(f"{host}: no release is on the robot, so no app runs")
    else:
        write_state(host, ssh_config, state)
    return 0
