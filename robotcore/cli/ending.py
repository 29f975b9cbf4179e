"""How a run's end is told: one line of JSON, or a summary and what went wrong."""

from __future__ import annotations

from collections.abc import Mapping
from traceback import format_exception
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.failure import tell
from robotcore.errors import BehaviourError, Interrupted, RobotcoreError

if TYPE_CHECKING:
    from robotcore.outcome import RunResult


def unstarted(asked: Mapping[str, Any], error: RobotcoreError | Interrupted) -> RunResult:
    """Return the result of a run that ended before it began; ``asked`` is what is known of the request."""
    from robotcore.outcome import Outcome, RunResult

    return RunResult(
        app=asked.get("app") or "",
        backend=asked.get("backend") or "",
        robot=asked.get("robot") or "",
        world=asked.get("world"),
        seed=asked.get("seed"),
        outcome=Outcome.INTERRUPTED if isinstance(error, Interrupted) else Outcome.ERROR,
        exit_status=error.exit_status,
        reason=str(error),
        error=error,
    )


def tell_result(result: RunResult, *, as_json: bool) -> None:
    """Tell how a run ended: on stderr what went wrong, on stdout the result."""
    if isinstance(result.error, BehaviourError) and (cause := result.error.__cause__):
        click.echo("".join(format_exception(cause)), err=True, nl=False)
    if isinstance(result.error, RobotcoreError) or (result.error and not result.ticks):
        tell(result.reason)
    if as_json:
        write_result(result)
    elif result.ticks:
        from robotcore.cli.output import write
        from robotcore.view.summary import summary

        write(summary(result))


def write_result(result: RunResult) -> None:
    """Write the one line of JSON."""
    click.echo(result.to_json())
