"""What every command to a robot takes, and how a signal ends one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.errors import UsageError

if TYPE_CHECKING:
    from robotcore.deploy.host import Host
    from robotcore.deploy.link import Link


class HostType(click.ParamType):
    """A robot, by the name that ssh knows it by."""

    name = "host"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Host:
        from robotcore.deploy.host import Host

        try:
            return value if isinstance(value, Host) else Host.parse(value)
        except UsageError as error:
            self.fail(str(error), param, ctx)


def on_robot(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command HOST and ``--ssh-config``."""
    config = click.option(
        "--ssh-config",
        metavar="FILE",
        type=click.Path(path_type=Path, exists=True, dir_okay=False),
        help="An ssh configuration instead of yours.",
    )
    return click.argument("host", type=HostType())(config(command))


def link_to(host: Host, ssh_config: Path | None) -> Link:
    """Return the link to a robot, not yet connected."""
    from robotcore.deploy.link import Link

    return Link(host, config=ssh_config)
