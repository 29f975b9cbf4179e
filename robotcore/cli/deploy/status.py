"""``robotcore deploy status``: print the state of a robot.

``--json`` prints ``host``, the robot's state: ``release``, ``verdict``, ``on_trial``, ``last``, ``state``,
``for_s``, ``restarts``, ``words``, ``reason``, ``lines``, ``starts_with_robot``, ``lingers``, ``recordings``,
``free_bytes``; and ``exit_status``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import AnsweringDeployCommand, make_link, robot_arguments
from robotcore.cli.deploy._output import choose_exit_status, write_state
from robotcore.cli.output import as_json, write_json

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress


@click.command("status", cls=AnsweringDeployCommand)
@robot_arguments
@as_json
def command(host: RobotAddress, ssh_config: Path | None, *, as_json: bool) -> int:
    """Print which release HOST runs, since when, and what it is doing.

    Exit status: 0 it runs or has ended with success, 1 it does not run, 3 the robot cannot be reached.
    """
    from robotcore.deploy.robot_answers import StatusAnswer

    with make_link(host, ssh_config) as link:
        state = link.call("status", StatusAnswer)
    status = choose_exit_status(state)
    if as_json:
        write_json({"host": str(host), **state.model_dump(by_alias=True), "exit_status": status})
    else:
        write_state(host, ssh_config, state)
    return status
