"""``robotcore deploy status``: how a robot does.

``--json`` prints ``host`` and what the robot tells: ``release``, ``verdict``, ``on_trial``, ``last``, ``state``,
``for_s``, ``restarts``, ``words``, ``reason``, ``lines``, ``starts_with_robot``, ``lingers``, ``recordings``,
``free_bytes``; and ``exit_status``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import AnsweringDeployCommand, link_to, on_robot
from robotcore.cli.deploy._output import status_of, tell_state
from robotcore.cli.output import as_json, write_json

if TYPE_CHECKING:
    from robotcore.deploy.host import Host


@click.command("status", cls=AnsweringDeployCommand)
@on_robot
@as_json
def command(host: Host, ssh_config: Path | None, *, as_json: bool) -> int:
    """Tell which release HOST runs, since when, and what it is doing.

    Exit status: 0 it runs, or has ended with a success, 1 it does not, 3 the robot cannot be reached.
    """
    from robotcore.deploy.answers import State

    with link_to(host, ssh_config) as link:
        state = link.call("status", State)
    status = status_of(state)
    if as_json:
        write_json({"host": str(host), **state.model_dump(), "exit_status": status})
    else:
        tell_state(host, ssh_config, state)
    return status
