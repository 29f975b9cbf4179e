"""Commands that answer in one line of JSON, also if they fail."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.output import write, write_content, write_error, write_failure, write_json, write_line
from robotcore.errors import Interrupted, RobotcoreError, UsageError

if TYPE_CHECKING:
    from robotcore.runtime.result import RunResult


class AnsweringCommand(click.Command):
    """With ``--json``, whatever keeps it from its own answer ends in one line with ``app``, ``error``, ``exit_status``.

    The error is raised again, and written on stderr. While the command runs, a signal raises Interrupted.
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
        from robotcore.runtime.signals import SignalGuard

        with SignalGuard():
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


class RunCommand(AnsweringCommand):
    """Answers with all the keys of a result, also where the run did not begin."""

    def unanswered(self, asked: Mapping[str, Any], error: RobotcoreError | Interrupted) -> dict[str, Any]:
        return {**json.loads(_result_without_run(asked, error).to_json()), **super().unanswered(asked, error)}


def prepare_result(*, as_json: bool) -> None:
    """Import what `write_result` needs: an app may leave no file descriptor, and no memory, for an import."""
    if not as_json:
        import robotcore.view.text  # noqa: F401


def write_result(result: RunResult, *, as_json: bool) -> None:
    """Tell how a run ended: on stderr what is to be known of it and what went wrong, on stdout the result."""
    for note in result.notes:
        write_line(f"note: {note}", is_error=True)
    if isinstance(result.error, RobotcoreError):
        write_error(result.error)
    elif result.error and not result.ticks:
        write_failure(result.reason)
    if as_json:
        write_content(f"{result.to_json()}\n")
    elif result.ticks:
        from robotcore.view.text import format_summary

        write(format_summary(result))


def _result_without_run(asked: Mapping[str, Any], error: RobotcoreError | Interrupted) -> RunResult:
    """Return the result of a run that ended before it began; ``asked`` is what is known of the request."""
    from robotcore.runtime.result import Outcome, RunResult

    return RunResult(
        app=asked.get("app") or "",
        backend=asked.get("backend") or "",
        robot=asked.get("robot") or "",
        world=asked.get("world"),
        seed=asked.get("seed"),
        outcome=Outcome.INTERRUPTED if isinstance(error, Interrupted) else Outcome.ERROR,
        exit_status=error.exit_status,
        reason=str(error),
        faults=list(asked.get("faults") or ()),
    )
