"""``robotcore deploy logs``: print the log of the app on a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from robotcore.cli.deploy._options import DeployCommand, make_link, robot_arguments
from robotcore.cli.output import write_line

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress


LINE_BYTES = 1 << 16
"""The greatest length of a log line, in bytes. journald splits lines at 48 kB. Source: journald.conf(5), LineMax."""

OVERHEAD_BYTES = 1 << 20
"""The greatest length of the messages by systemd and journalctl, in bytes, in addition to the app's lines."""


@click.command("logs", cls=DeployCommand)
@robot_arguments
@click.option("-f", "--follow", is_flag=True, help="Print new lines as they come, until Ctrl-C.")
@click.option(
    "-n",
    "--lines",
    metavar="N",
    type=click.IntRange(1),
    default=50,
    show_default=True,
    help="Number of past lines to show.",
)
def command(host: RobotAddress, ssh_config: Path | None, lines: int, *, follow: bool) -> int:
    """Print the log of the app on HOST, with systemd's messages about it. Ctrl-C does not stop the app."""
    from robotcore.errors import Interrupted

    try:
        with make_link(host, ssh_config) as link:
            max_bytes = None if follow else OVERHEAD_BYTES + lines * LINE_BYTES
            link.stream("logs", on_line=write_line, max_bytes=max_bytes, lines=lines, follow=follow)
    except Interrupted as interruption:
        if not follow:
            raise
        return interruption.exit_status
    return 0
