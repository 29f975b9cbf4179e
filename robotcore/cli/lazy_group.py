"""A group of commands that are imported when they are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import click

from robotcore.errors import UnknownNameError


class LazyGroup(click.Group):
    """Each command is the ``command`` of the module of its name in ``package``."""

    def __init__(self, *args: Any, package: str, names: Sequence[str], **more: Any) -> None:
        super().__init__(*args, **more)
        self._package, self._names = package, tuple(names)

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self._names)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self._names:
            return None
        command: click.Command = import_module(f"{self._package}.{cmd_name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; UnknownNameError offers the nearest one."""
        if args[0] not in self._names and not args[0].startswith("-"):
            raise UnknownNameError("command", args[0], self._names)
        return super().resolve_command(ctx, args)
