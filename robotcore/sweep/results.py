"""The results folder of a sweep: which runs are done, and which are missing."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from datetime import datetime, timezone
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from robotcore.description import load_world
from robotcore.errors import UsageError
from robotcore.runtime.apps import app_name, app_path
from robotcore.runtime.plan import RunRequest
from robotcore.sweep.durable import Journal, part_path
from robotcore.sweep.fingerprint import (
    MANIFEST,
    Dependencies,
    collect_dependencies,
    compute_digest,
    format_manifest,
    require_same,
    write_manifest,
)
from robotcore.sweep.record import Record
from robotcore.sweep.single_run import RunOutput
from robotcore.sweep.spec import Sweep, format_seeds
from robotcore.sweep.tables import FAILURES, TABLE, are_current, write_tables

RESULTS, PICTURES = "results.jsonl", "failures"
_DISK_FULL = (errno.ENOSPC, errno.EDQUOT)


class Results:
    """The results of one sweep in one folder; while entered, this process alone adds to them.

    The folder may have those of other seeds too, which are left alone.

    A run is on the disk before the next one is taken, so that whatever ends the sweep loses none that was done.
    """

    def __init__(self, sweep: Sweep, directory: Path | None = None, *, fresh: bool = False) -> None:
        """``directory`` is ``sweeps/<app>-<digest>`` where it is None; ``fresh`` forgets what is there, all of it."""
        self.sweep, self._fresh = sweep, fresh
        self._directory = directory
        self._journal: Journal | None = None

    def __repr__(self) -> str:
        return f"Results({self.sweep!r}, {self._directory!r})"

    @cached_property
    def directory(self) -> Path:
        """The folder."""
        return self._directory or Path("sweeps") / f"{_short_name(self.sweep)}-{compute_digest(self._parts)[:8]}"

    @cached_property
    def _parts(self) -> Dependencies:
        return collect_dependencies(self.sweep)

    @cached_property
    def _wanted(self) -> RunFilter:
        return RunFilter(self.sweep)

    def __enter__(self) -> Results:
        try:
            self._open_folder()
        except OSError as error:
            raise self._make_open_error(error) from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._close()

    @property
    def date(self) -> datetime:
        """When the last run was added."""
        changed = (self.directory / RESULTS).stat().st_mtime
        return datetime.fromtimestamp(changed, tz=timezone.utc).astimezone()

    @property
    def resume_hint(self) -> str:
        """How to resume the sweep, for a message."""
        return f"the same command{' without --fresh' if self._fresh else ''} goes on"

    def records(self) -> Iterator[Record]:
        """Yield what is done of the runs that are asked for, in the order in which they were."""
        file = self.directory / RESULTS
        return read_results(file, self._wanted) if file.exists() else iter(())

    def missing(self) -> list[RunRequest]:
        """Return the runs that are still to do."""
        done = set(map(RunKey.of, self.records()))
        return [request for request in self.sweep.requests() if self._wanted.run_of(request) not in done]

    def add(self, ended: RunOutput) -> Record:
        """Keep one run, its picture first; return its record. UsageError where the disk does not take it."""
        assert self._journal, "results are added while the folder is held"
        with self._report_write_errors():
            record = self._with_picture(ended)
            self._journal.add(record.to_json())
        return record

    def write_tables(self) -> None:
        """Write `tables.TABLE` and `tables.FAILURES`; not where they tell all by now."""
        if not are_current(self.directory, self.directory / RESULTS):
            with self._report_write_errors():
                write_tables(self.directory, self.records)

    def _open_folder(self) -> None:
        self.directory.mkdir(parents=True, exist_ok=True)
        self._require_sweep_or_empty()
        with ExitStack() as on_failure:
            self._journal = Journal.open(self.directory / RESULTS)
            on_failure.callback(self._close)
            self._claim_folder()
            on_failure.pop_all()

    def _require_sweep_or_empty(self) -> None:
        """Refuse a folder of something else; what a sweep leaves that was killed over its first file is nothing."""
        if (self.directory / MANIFEST).exists():
            return
        begun = {RESULTS, part_path(self.directory / MANIFEST).name}
        if any(file.name not in begun or _has_results(file) for file in self.directory.iterdir()):
            raise UsageError(
                f"{self.directory} holds something that is no sweep. Name a new folder with --out",
                kind="not-a-sweep",
                directory=str(self.directory),
            )

    def _claim_folder(self) -> None:
        """Let the folder, which nobody else writes to by now, be that of this sweep; refuse what has other results."""
        spec, content = self.directory / MANIFEST, format_manifest(self._parts, format_seeds(self.sweep.seeds))
        if self._fresh:
            self._delete_results()
        elif spec.exists():
            require_same(self.directory, self._parts)
        if not spec.exists() or spec.read_bytes() != content.encode():
            self._drop_tables()
            write_manifest(self.directory, content)

    def _drop_tables(self) -> None:
        """Drop the tables, which tell of what was asked for until now."""
        for name in (TABLE, FAILURES):
            (self.directory / name).unlink(missing_ok=True)

    def _close(self) -> None:
        if self._journal:
            self._journal.close()
            self._journal = None

    def _delete_results(self) -> None:
        assert self._journal
        self._journal.clear()
        for file in (self.directory / PICTURES).glob("*.png"):
            file.unlink()

    def _with_picture(self, ended: RunOutput) -> Record:
        """Return the record, its picture written."""
        if ended.picture is None:
            return ended.record
        result = ended.record.result
        name = f"{PICTURES}/{result.backend}-{result.world}-{result.seed}.png"
        (self.directory / PICTURES).mkdir(exist_ok=True)
        (self.directory / name).write_bytes(ended.picture)
        return replace(ended.record, picture=name)

    def _make_open_error(self, error: OSError) -> UsageError:
        fault = "it is no folder" if isinstance(error, FileExistsError) else error.strerror
        return UsageError(
            f"{error.filename or self.directory}: {fault}. Nothing was run; "
            "let --out name a folder that can be written",
            kind="unusable-folder",
            directory=str(self.directory),
        )

    @contextmanager
    def _report_write_errors(self) -> Iterator[None]:
        """Turn an OSError into a UsageError that says how to resume."""
        try:
            yield
        except OSError as error:
            remedy = "make room" if error.errno in _DISK_FULL else "let it be written"
            raise UsageError(
                f"{error.filename or self.directory}: {error.strerror}. What is done is kept; {remedy}, and "
                f"{self.resume_hint}",
                kind="results-not-written",
                file=str(error.filename or self.directory),
                resume_hint=self.resume_hint,
            ) from error


def _short_name(sweep: Sweep) -> str:
    """Return the app's name, or its file's without the ending."""
    return app_path(app_name(sweep.request.app)).stem


def _has_results(file: Path) -> bool:
    """Return whether a file holds results."""
    return file.name == RESULTS and file.stat().st_size > 0


class RunKey(NamedTuple):
    """The identity of a run in its sweep; the world is the name in its description."""

    backend: str
    world: str | None
    seed: int | None

    @classmethod
    def of(cls, record: Record) -> RunKey:
        """Return the key of a record's run."""
        return cls(record.result.backend, record.result.world, record.result.seed)

    def __str__(self) -> str:
        return f"{self.backend}, {self.world}, seed {self.seed}"


class RunFilter:
    """The set of runs of a sweep."""

    def __init__(self, sweep: Sweep) -> None:
        self._worlds = {world: load_world(world).name for world in sweep.worlds}
        self._parts = frozenset(sweep.backends), frozenset(self._worlds.values()), frozenset(sweep.seeds)

    def __contains__(self, run: RunKey) -> bool:
        return all(part in wanted for part, wanted in zip(run, self._parts, strict=True))

    def run_of(self, request: RunRequest) -> RunKey:
        """Return the key of one of the sweep's requests."""
        assert request.world, "a sweep names its worlds"
        return RunKey(request.backend, self._worlds[request.world], request.seed)


def read_results(file: Path, wanted: RunFilter) -> Iterator[Record]:
    """Read the results file, and yield only the runs of this sweep, in the file's order.

    Raises UsageError, with the number of the line, if it is no record or the second record of a run.
    """
    seen: set[RunKey] = set()
    for where, record in _read_records(file):
        if (run := RunKey.of(record)) not in wanted:
            continue
        if run in seen:
            raise UsageError(
                f"{where}: the run {run} is there already. Delete one of its lines", kind="duplicate-run", where=where
            )
        seen.add(run)
        yield record


def _read_records(file: Path) -> Iterator[tuple[str, Record]]:
    with file.open("rb") as lines:
        for number, line in enumerate(lines, 1):
            where = f"{file}, line {number}"
            try:
                yield where, Record.from_json(line)
            except ValueError as error:
                raise UsageError(
                    f"{where}: {error}. Delete this line, and that run alone is run again",
                    kind="bad-record",
                    where=where,
                ) from error
