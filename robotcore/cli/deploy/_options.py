"""Arguments and base classes of the commands of ``robotcore deploy``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.command_classes import AnsweringCommand
from robotcore.errors import Interrupted, RobotcoreError

if TYPE_CHECKING:
    from robotcore.deploy.host import Host
    from robotcore.deploy.rpc import Link


class DeployCommand(click.Command):
    """A command that raises Interrupted at SIGINT and SIGTERM, so that it stops the processes that it started."""

    def invoke(self, ctx: click.Context) -> Any:
        from robotcore.runtime.signals import SignalGuard

        with SignalGuard():
            return super().invoke(ctx)


class AnsweringDeployCommand(AnsweringCommand):
    """A command whose answer to ``--json`` after an error has ``host``, ``error`` and ``exit_status``."""

    def build_failure_answer(
        self, parameters: Mapping[str, Any], error: RobotcoreError | Interrupted
    ) -> dict[str, Any]:
        return {"host": str(parameters.get("host") or ""), "error": str(error), "exit_status": error.exit_status}


def robot_arguments(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the argument HOST and the option ``--ssh-config`` to a command."""
    config = click.option(
        "--ssh-config",
        metavar="FILE",
        type=click.Path(path_type=Path, exists=True, dir_okay=False),
        help="An ssh configuration file in place of yours.",
    )
    return click.argument("host", type=_parse_host)(config(command))


def make_link(host: Host, ssh_config: Path | None) -> Link:
    """Return a link to a robot. The link connects when its ``with`` block begins."""
    from robotcore.deploy.rpc import Link

    return Link(host, ssh_config)


def _parse_host(value: str) -> Host:
    from robotcore.deploy.host import Host

    return Host.parse(value)
