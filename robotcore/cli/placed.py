"""Options that name where a robot is plugged in, for commands that look at it and run nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.values import pair
from robotcore.errors import UnknownNameError

if TYPE_CHECKING:
    from robotcore.description import RobotDescription
    from robotcore.hal.backend import Backend

Command = Callable[..., Any]


def placed(command: Command) -> Command:
    """Give a command ``--port`` and ``--option``; `options_of` puts together what it takes for them."""
    told = click.option("--option", "options", metavar="KEY=VALUE", type=pair, multiple=True, help="Of the backend.")
    return click.option("--port", help="Short for --option port=…: where the robot is plugged in.")(told(command))


def options_of(port: str | None, options: tuple[tuple[str, str], ...]) -> dict[str, str]:
    """Return the options of a backend."""
    return {**dict(options), **({} if port is None else {"port": port})}


def placed_robot(backend: Backend, robot: str, options: Mapping[str, str]) -> RobotDescription:
    """Return a robot as it is plugged in; raises UsageError where an option says nothing of that."""
    for unknown in sorted(options.keys() - backend.placing):
        raise UnknownNameError("option", unknown, sorted(backend.placing))
    return backend.described(robot, options)
