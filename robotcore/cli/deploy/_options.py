"""The argument HOST and the base classes of the commands of ``robotcore deploy``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.command_classes import AnsweringCommand
from robotcore.errors import Interrupted, RobotcoreError
from robotcore.system import require_posix

if TYPE_CHECKING:
    from robotcore.deploy.host import RobotAddress
    from robotcore.deploy.rpc import RobotLink


class DeployCommand(click.Command):
    """A command that raises Interrupted at SIGINT and SIGTERM, so that its child processes end."""

    def invoke(self, ctx: click.Context) -> Any:
        from robotcore.runtime.signals import SignalGuard

        with SignalGuard():
            return super().invoke(ctx)


class AnsweringDeployCommand(AnsweringCommand):
    """A deploy command with ``--json``, whose answer after an error has the robot's address."""

    def build_failure_answer(
        self, parameters: Mapping[str, Any], error: RobotcoreError | Interrupted
    ) -> dict[str, Any]:
        """Return the JSON answer of a command that failed.

        The JSON keys:

        host: text; the robot's address.
        *: robotcore.cli.command_classes.AnsweringCommand._write_answer
        """
        return {"host": str(parameters.get("host") or ""), "error": str(error), "exit_status": error.exit_status}


def robot_argument(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the argument HOST and the option ``--ssh-config`` to a command. The command gets both as ``host``."""

    @click.argument("host", type=_parse_host)
    @click.option(
        "--ssh-config",
        metavar="FILE",
        type=click.Path(path_type=Path, exists=True, dir_okay=False),
        help="An ssh configuration file in place of yours.",
    )
    @wraps(command)
    def run(host: RobotAddress, ssh_config: Path | None, **chosen: Any) -> Any:
        needed = "the processes, permissions and links of POSIX, and OpenSSH with shared connections"
        require_posix("robotcore deploy", needed, "Run it in WSL, the Linux of Windows: wsl --install")
        return command(replace(host, ssh_config=ssh_config), **chosen)

    return run


def _parse_host(value: str) -> RobotAddress:
    from robotcore.deploy.host import RobotAddress

    return RobotAddress.parse(value)


def make_link(host: RobotAddress) -> RobotLink:
    """Return a link to a robot, which connects at the beginning of its ``with`` block."""
    from robotcore.deploy.rpc import RobotLink

    return RobotLink(host)
