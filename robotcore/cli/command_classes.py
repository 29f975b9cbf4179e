"""Classes of commands: a group that imports its commands lazily, and commands that answer in one line of JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from importlib import import_module
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.output import (
    format_usage_error,
    write,
    write_content,
    write_error,
    write_failure,
    write_json,
    write_line,
)
from robotcore.errors import Interrupted, RobotcoreError, UnknownNameError, UsageError

if TYPE_CHECKING:
    from robotcore.runtime.result import RunResult


class LazyGroup(click.Group):
    """A group that imports a command's module only if the command is used.

    package: the name of the package with the modules of the commands.
    commands: the commands in the order of the help. ``"run"`` is the function ``command`` of the module ``run``.
        ``"lists:apps"`` is the function ``apps`` of the module ``lists``.
    """

    def __init__(self, *args: Any, package: str, commands: Sequence[str], **more: Any) -> None:
        super().__init__(*args, **more)
        self._package = package
        self._places = {name.rpartition(":")[2]: name for name in commands}

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self._places)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self._places:
            return None
        module, _, function = self._places[cmd_name].replace("-", "_").partition(":")
        command: click.Command = getattr(import_module(f"{self._package}.{module}"), function or "command")
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command. An unknown name raises UnknownNameError, which suggests the nearest name."""
        if args[0] not in self._places and not args[0].startswith("-"):
            raise UnknownNameError("command", args[0], list(self._places))
        return super().resolve_command(ctx, args)


class AnsweringCommand(click.Command):
    """A command that answers with one line of JSON if ``--json`` is given, even if the command fails.

    The error of a failed command is also raised, so that `execute` writes it on stderr. While the command runs, a
    signal raises Interrupted.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        given = list(args)
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            error.ctx = error.ctx or ctx  # click's parser leaves it out if an option lacks its value
            if "--json" in given:
                kind = "unknown-option" if isinstance(error, click.NoSuchOption) else ""
                self._write_answer(self._parse_leniently(ctx, given), UsageError(format_usage_error(error), kind=kind))
            raise

    def invoke(self, ctx: click.Context) -> Any:
        from robotcore.runtime.signals import SignalGuard

        with SignalGuard():
            try:
                return super().invoke(ctx)
            except (RobotcoreError, Interrupted) as error:
                if ctx.params["as_json"]:
                    self._write_answer(ctx.params, error)
                raise

    def build_failure_answer(
        self, parameters: Mapping[str, Any], error: RobotcoreError | Interrupted
    ) -> dict[str, Any]:
        """Return the JSON answer of a command that failed.

        parameters: the command's valid parameters, by name.
        error: the error that ended the command.

        The JSON keys:

        app: text; the app of the command; empty if it has none. Only after an error.
        *: robotcore.cli.command_classes.AnsweringCommand._write_answer
        """
        return {"app": parameters.get("app") or "", "error": str(error), "exit_status": error.exit_status}

    def _parse_leniently(self, ctx: click.Context, given: list[str]) -> dict[str, Any]:
        return self.make_context(
            ctx.info_name, given, resilient_parsing=True, ignore_unknown_options=True, allow_extra_args=True
        ).params

    def _write_answer(self, parameters: Mapping[str, Any], error: RobotcoreError | Interrupted) -> None:
        """Write the JSON answer of a command that failed.

        The JSON keys:

        error: text; the message of the error. Only after an error.
        kind: text; a stable identifier of the error, such as ``unknown-app``. Only after an error.
        exit_status: whole number; the exit status. Only after an error.
        """
        with suppress(OSError):  # stdout is closed, so only the exit status reports the failure
            write_json({**self.build_failure_answer(parameters, error), "kind": error.kind})


class RunCommand(AnsweringCommand):
    """A command whose JSON answer has all keys of a RunResult, even if the run did not begin."""

    def build_failure_answer(
        self, parameters: Mapping[str, Any], error: RobotcoreError | Interrupted
    ) -> dict[str, Any]:
        result = json.loads(_build_result_without_run(parameters, error).to_json())
        return {**result, **super().build_failure_answer(parameters, error)}


def prepare_result(*, as_json: bool) -> None:
    """Import the modules that `write_result` needs before the run, because the app may use up the memory."""
    if not as_json:
        import robotcore.view.text  # noqa: F401


def write_result(result: RunResult, *, as_json: bool) -> None:
    """Write the result of a run on stdout, and its error and the notes that are not yet written on stderr.

    The JSON comes first, because a full pipe at stderr blocks. If an error ended the run, the JSON also has the keys
    ``error``, its message, and ``kind``, which identifies it.
    """
    if as_json and isinstance(result.error, RobotcoreError | Interrupted):
        write_json({**json.loads(result.to_json()), "error": str(result.error), "kind": result.error.kind})
    elif as_json:
        write_content(f"{result.to_json()}\n")
    _write_notes(result)
    if not as_json and result.ticks:
        from robotcore.view.text import format_summary

        write(format_summary(result))


def _write_notes(result: RunResult) -> None:
    from robotcore.runtime.result import WrittenNote

    for note in result.notes:
        if not isinstance(note, WrittenNote):
            write_line(f"note: {note}", is_error=True)
    if isinstance(result.error, RobotcoreError):
        write_error(result.error)
    elif result.error and not result.ticks:
        write_failure(result.reason)


def _build_result_without_run(parameters: Mapping[str, Any], error: RobotcoreError | Interrupted) -> RunResult:
    from robotcore.runtime.result import Outcome, RunResult

    return RunResult(
        app=parameters.get("app") or "",
        backend=parameters.get("backend") or "",
        robot=parameters.get("robot") or "",
        world=parameters.get("world"),
        seed=parameters.get("seed"),
        outcome=Outcome.INTERRUPTED if isinstance(error, Interrupted) else Outcome.ERROR,
        exit_status=error.exit_status,
        reason=str(error),
        faults=list(parameters.get("faults") or ()),
    )
