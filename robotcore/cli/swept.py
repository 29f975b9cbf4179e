"""How a sweep's end is told: a summary and what was missed, or one line of JSON; and the exit status."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.failure import tell
from robotcore.cli.output import write, write_json

if TYPE_CHECKING:
    from robotcore.errors import Interrupted
    from robotcore.sweep.record import Record
    from robotcore.sweep.requirements import Requirement
    from robotcore.sweep.results import Results
    from robotcore.sweep.statistics import Group

MISSED = 1
"""Some --require was not kept."""


def tell_kept(results: Results, done: int) -> None:
    """Tell, before the first run, how many are there from before, and since when."""
    date, total = f"{results.date:%Y-%m-%d %H:%M}", len(results.sweep)
    if done == total:
        click.echo(f"All was run by {date}; --fresh runs it anew.\n")
    else:
        click.echo(f"{done} of {total} runs are kept from {date}; going on.\n")


def tell_sweep(
    results: Results, requirements: Sequence[Requirement], interrupted: Interrupted | None, *, as_json: bool
) -> int:
    """Tell what a sweep reached; return its exit status. One that was interrupted is held to no requirement."""
    from robotcore.sweep.requirements import missed
    from robotcore.sweep.statistics import grouped

    groups = grouped(results.records())
    failing = [record for record in results.records() if record.is_failure]
    misses = [] if interrupted else missed(requirements, groups)
    status = interrupted.exit_status if interrupted else MISSED if misses else 0
    if as_json:
        write_json({**_told(results, groups, failing), "missed": misses, "exit_status": status})
    elif groups:
        _write_summary(results, groups, failing)
        _write_findings(results)
    _tell_ending(results, groups, misses, interrupted)
    return status


def _told(results: Results, groups: Sequence[Group], failing: Sequence[Record]) -> dict[str, Any]:
    return {
        "app": results.sweep.request.app,
        "directory": str(results.directory),
        "runs": len(results.sweep),
        "done": sum(group.runs for group in groups),
        "failing": len(failing),
        "groups": [{**asdict(group), "verified_95": group.verified_95} for group in groups],
    }


def _write_summary(results: Results, groups: Sequence[Group], failing: Sequence[Record]) -> None:
    from robotcore.sweep.summary import summary
    from robotcore.sweep.tables import FAILURES

    write(summary(results.sweep.request, groups, failing, results.directory / FAILURES))
    click.echo(f"\nThe results: {results.directory}")


def _write_findings(results: Results) -> None:
    """Tell which conditions explain failures, or why none is named."""
    from robotcore.sweep.explain import explain

    lines = explain(results.records()).lines
    if lines:
        click.echo("\nWhat failing runs have in common:")
    for line in lines:
        click.echo(f"  {line}")


def _tell_ending(
    results: Results, groups: Sequence[Group], misses: Sequence[str], interrupted: Interrupted | None
) -> None:
    for miss in misses:
        tell(miss)
    if interrupted:
        done = sum(group.runs for group in groups)
        click.echo(f"{interrupted}: {done} of {len(results.sweep)} runs are kept; {results.how_to_go_on}.", err=True)
