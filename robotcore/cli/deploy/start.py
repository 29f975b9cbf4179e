"""``robotcore deploy start``: the app runs on a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import DeployCommand, link_to, on_robot
from robotcore.cli.deploy._output import status_of, tell_state

if TYPE_CHECKING:
    from robotcore.deploy.host import Host


@click.command("start", cls=DeployCommand)
@on_robot
def command(host: Host, ssh_config: Path | None) -> int:
    """Let the release on HOST run, now and whenever the robot is switched on."""
    from robotcore.deploy.answers import State

    with link_to(host, ssh_config) as link:
        state = link.call("start", State)
    tell_state(host, ssh_config, state)
    return status_of(state)
