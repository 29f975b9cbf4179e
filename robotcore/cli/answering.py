"""A command that answers in JSON where it was asked to, also where nothing could be run."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import click

from robotcore.cli.output import write_json
from robotcore.errors import Interrupted, RobotcoreError, UsageError


class AnsweringCommand(click.Command):
    """With ``--json``, whatever keeps it from its own answer ends in one line with ``app``, ``error``, ``exit_status``.

    What is raised goes on, to be told on stderr. While it runs, a signal raises Interrupted.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        given = list(args)
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            if "--json" in given:
                self._answer(self._understood(ctx, given), UsageError(error.format_message()))
            raise

    def invoke(self, ctx: click.Context) -> Any:
        from robotcore.runtime.signals import Interrupts

        with Interrupts():
            try:
                return super().invoke(ctx)
            except (RobotcoreError, Interrupted) as error:
                if ctx.params["as_json"]:
                    self._answer(ctx.params, error)
                raise

    def unanswered(self, asked: Mapping[str, Any], error: RobotcoreError | Interrupted) -> dict[str, Any]:
        """Return the answer of a command that came to none; ``asked`` are its parameters, as far as they make sense."""
        return {"app": asked.get("app") or "", "error": str(error), "exit_status": error.exit_status}

    def _understood(self, ctx: click.Context, given: list[str]) -> dict[str, Any]:
        """Return the parameters that make sense."""
        return self.make_context(
            ctx.info_name, given, resilient_parsing=True, ignore_unknown_options=True, allow_extra_args=True
        ).params

    def _answer(self, asked: Mapping[str, Any], error: RobotcoreError | Interrupted) -> None:
        with suppress(OSError):  # where nobody reads, the exit status tells
            write_json(self.unanswered(asked, error))
