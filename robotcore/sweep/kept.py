"""The lines of a sweep's results, as far as they are of the runs that are asked for."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from robotcore.description import load_world
from robotcore.errors import UsageError
from robotcore.runtime.plan import RunRequest
from robotcore.sweep.record import Record
from robotcore.sweep.spec import Sweep


class Run(NamedTuple):
    """What tells a run from the others of its sweep; a world is called what its description says."""

    backend: str
    world: str | None
    seed: int | None

    @classmethod
    def of(cls, record: Record) -> Run:
        """Return which run it is that a record tells of."""
        return cls(record.result.backend, record.result.world, record.result.seed)

    def __str__(self) -> str:
        return f"{self.backend}, {self.world}, seed {self.seed}"


class Wanted:
    """The runs that a sweep asks for."""

    def __init__(self, sweep: Sweep) -> None:
        self._worlds = {world: load_world(world).name for world in sweep.worlds}
        self._parts = frozenset(sweep.backends), frozenset(self._worlds.values()), frozenset(sweep.seeds)

    def __contains__(self, run: Run) -> bool:
        return all(part in wanted for part, wanted in zip(run, self._parts, strict=True))

    def run_of(self, request: RunRequest) -> Run:
        """Return which run is asked for; the request is one of the sweep's."""
        assert request.world, "a sweep names its worlds"
        return Run(request.backend, self._worlds[request.world], request.seed)


def kept(file: Path, wanted: Wanted) -> Iterator[Record]:
    """Yield those records of a file that are wanted, in its order.

    Raises UsageError, with the number of the line, where it is no record or the second one of a run.
    """
    seen: set[Run] = set()
    for where, record in _records(file):
        if (run := Run.of(record)) not in wanted:
            continue
        if run in seen:
            raise UsageError(f"{where}: the run {run} is there already. Delete one of its lines")
        seen.add(run)
        yield record


def _records(file: Path) -> Iterator[tuple[str, Record]]:
    with file.open("rb") as lines:
        for number, line in enumerate(lines, 1):
            where = f"{file}, line {number}"
            try:
                yield where, Record.from_json(line)
            except ValueError as error:
                raise UsageError(f"{where}: {error}. Delete this line, and that run alone is run again") from error
