"""A sweep from its first run to its tables."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from robotcore.sweep.engine import Engine
from robotcore.sweep.local import LocalEngine, cores
from robotcore.sweep.record import Record
from robotcore.sweep.rehearsal import rehearse
from robotcore.sweep.results import Results
from robotcore.sweep.spec import Sweep

Watcher = Callable[[Record], None]


def run_sweep(
    sweep: Sweep,
    engine: Engine | None = None,
    directory: Path | None = None,
    *,
    fresh: bool = False,
) -> Results:
    """Run what is not yet done of a sweep, on all cores where no engine is given; return its results.

    Raises UsageError and BackendMissingError before anything is run.
    """
    rehearse(sweep)
    with Results(sweep, directory, fresh=fresh) as results:
        execute(results, engine or LocalEngine(cores()))
    return results


def execute(results: Results, engine: Engine, watch: Watcher = lambda _: None) -> None:
    """Run what is missing, and write the tables of what is there, however it ends."""
    try:
        if missing := results.missing():
            with closing(engine.perform(results.sweep, missing)) as ended:
                for each in ended:
                    watch(results.add(each))
    finally:
        results.write_tables()
