"""How a run's end is told: one line of JSON, or a summary and what went wrong."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from robotcore.cli.answering import AnsweringCommand
from robotcore.cli.failure import tell, tell_error
from robotcore.cli.output import write, write_content, write_line
from robotcore.errors import Interrupted, RobotcoreError

if TYPE_CHECKING:
    from robotcore.runtime.result import RunResult


class RunCommand(AnsweringCommand):
    """Answers with all the keys of a result, also where the run did not begin."""

    def unanswered(self, asked: Mapping[str, Any], error: RobotcoreError | Interrupted) -> dict[str, Any]:
        return {**json.loads(_unstarted(asked, error).to_json()), **super().unanswered(asked, error)}


def prepare_telling(*, as_json: bool) -> None:
    """Import what `tell_result` needs: an app may leave no file descriptor, and no memory, for an import."""
    if not as_json:
        import robotcore.view.text  # noqa: F401


def tell_result(result: RunResult, *, as_json: bool) -> None:
    """Tell how a run ended: on stderr what is to be known of it and what went wrong, on stdout the result."""
    for note in result.notes:
        write_line(f"note: {note}", is_error=True)
    if isinstance(result.error, RobotcoreError):
        tell_error(result.error)
    elif result.error and not result.ticks:
        tell(result.reason)
    if as_json:
        write_content(f"{result.to_json()}\n")
    elif result.ticks:
        from robotcore.view.text import format_summary

        write(format_summary(result))


def _unstarted(asked: Mapping[str, Any], error: RobotcoreError | Interrupted) -> RunResult:
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
