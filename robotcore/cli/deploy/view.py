"""``robotcore deploy view``: show the live page of a robot's app, through ssh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import DeployCommand, make_link, robot_argument
from robotcore.cli.output import write_line
from robotcore.errors import Interrupted

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress


@click.command("view", cls=DeployCommand)
@robot_argument
def command(host: RobotAddress) -> int:
    """Print a link to the live page of the app on HOST, which works until Ctrl-C. The app runs on.

    The app must run with a page: robotcore deploy push --view.
    """
    from robotcore.deploy.page import forward_page

    try:
        with make_link(host) as link:
            page = forward_page(link)
            write_line(f"The live page of {host}, until Ctrl-C: {page}")
            link.wait()
    except Interrupted as interruption:
        return interruption.exit_status
    return 0
