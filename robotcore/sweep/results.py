"""The results folder of a sweep: add records, read them, and list the missing runs."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from datetime import datetime, timezone
from functools import cached_property
from pathlib import Path
from types import TracebackType

from robotcore.errors import UsageError
from robotcore.files import find_parts
from robotcore.runtime.apps import app_name, app_path
from robotcore.runtime.plan import RunRequest
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
from robotcore.sweep.results_file import Journal, RunFilter, RunKey, read_results
from robotcore.sweep.single_run import RunOutput
from robotcore.sweep.spec import Sweep, format_seeds
from robotcore.sweep.tables import FAILURES, TABLE, are_current, write_tables

RESULTS, PICTURES = "results.jsonl", "failures"
_DISK_FULL = (errno.ENOSPC, errno.EDQUOT)


class Results:
    """The results of a sweep in a folder. ``with`` locks the folder, so only one process at a time can add results.

    The folder may have results for other seeds too. They stay in the folder, and no method returns them.

    `add` returns after the record is on the disk. So no added record is lost if the sweep is killed.

    >>> from tempfile import mkdtemp
    >>> from robotcore import RunRequest
    >>> from robotcore.sweep import LocalEngine, Sweep, run_sweep
    >>> sweep = Sweep(RunRequest("avoid-obstacles", settings={"duration_s": 1}), worlds=("open",), seeds=(1, 2))
    >>> results = run_sweep(sweep, LocalEngine(jobs=1), Path(mkdtemp()))
    >>> [(record.result.seed, record.result.outcome.value) for record in results.records()]
    [(1, 'success'), (2, 'success')]
    >>> results.missing()
    []
    """

    def __init__(self, sweep: Sweep, directory: Path | None = None, *, fresh: bool = False) -> None:
        """Store the arguments. Nothing is written before the ``with`` statement.

        sweep: the sweep of the results.
        directory: the folder. None means ``sweeps/<app>-<digest>``.
        fresh: whether ``with`` deletes all results in the folder, including those of other seeds.
        """
        self.sweep, self._fresh = sweep, fresh
        self._directory = directory
        self._journal: Journal | None = None

    def __repr__(self) -> str:
        return f"Results({self.sweep!r}, {self._directory!r})"

    @cached_property
    def directory(self) -> Path:
        """The folder of the results."""
        return self._directory or Path("sweeps") / f"{_get_app_stem(self.sweep)}-{compute_digest(self._parts)[:8]}"

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
        """The time when the newest record was added."""
        changed = (self.directory / RESULTS).stat().st_mtime
        return datetime.fromtimestamp(changed, tz=timezone.utc).astimezone()

    @property
    def resume_hint(self) -> str:
        """The words that say which command resumes the sweep, for the end of an error message."""
        return f"the same command{' without --fresh' if self._fresh else ''} resumes the sweep"

    def records(self) -> Iterator[Record]:
        """Yield the records of this sweep's finished runs, in the order in which the runs ended.

        Raises UsageError if a line of the results file is not a record, or if a run has two lines.
        """
        file = self.directory / RESULTS
        return read_results(file, self._wanted) if file.exists() else iter(())

    def missing(self) -> list[RunRequest]:
        """Return the runs of this sweep that have no record yet."""
        done = set(map(RunKey.of, self.records()))
        return [request for request in self.sweep.requests() if self._wanted.make_key(request) not in done]

    def add(self, output: RunOutput) -> Record:
        """Write the picture and the record of a run, and return the record. Raises UsageError if the disk is full."""
        assert self._journal, "results are added inside with"
        with self._report_write_errors():
            record = self._write_picture(output)
            self._journal.append(record.to_json())
        return record

    def write_tables(self) -> None:
        """Write the tables ``results.csv`` and ``failures.csv``, unless they are newer than the results."""
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
        """Raise UsageError if the folder has files but no ``sweep.json``.

        An empty results file and temporary files are allowed: a sweep that was killed at its start leaves them.
        """
        if (self.directory / MANIFEST).exists():
            return
        others = set(self.directory.iterdir()) - set(find_parts(self.directory))
        if any(file.name != RESULTS or file.stat().st_size > 0 for file in others):
            raise UsageError(
                f"{self.directory} has other files than those of a sweep. Name a new folder with --out",
                kind="not-a-sweep",
                directory=str(self.directory),
            )

    def _claim_folder(self) -> None:
        for part in find_parts(self.directory):
            part.unlink()
        spec, content = self.directory / MANIFEST, format_manifest(self._parts, format_seeds(self.sweep.seeds))
        if self._fresh:
            self._delete_results()
        elif spec.exists():
            require_same(self.directory, self._parts)
        if not spec.exists() or spec.read_bytes() != content.encode():
            self._delete_tables()
            write_manifest(self.directory, content)

    def _delete_tables(self) -> None:
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

    def _write_picture(self, output: RunOutput) -> Record:
        if output.picture is None:
            return output.record
        result = output.record.result
        name = f"{PICTURES}/{result.backend}-{result.world}-{result.seed}.png"
        (self.directory / PICTURES).mkdir(exist_ok=True)
        (self.directory / name).write_bytes(output.picture)
        return replace(output.record, picture=name)

    def _make_open_error(self, error: OSError) -> UsageError:
        problem = "it is not a folder" if isinstance(error, FileExistsError) else error.strerror
        return UsageError(
            f"{error.filename or self.directory}: {problem}. No run was executed. Name a writable folder with --out",
            kind="unusable-folder",
            directory=str(self.directory),
        )

    @contextmanager
    def _report_write_errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            remedy = "Free some space" if error.errno in _DISK_FULL else "Make the file writable"
            raise UsageError(
                f"{error.filename or self.directory}: {error.strerror}. The finished runs are saved. {remedy}, and "
                f"{self.resume_hint}",
                kind="results-not-written",
                file=str(error.filename or self.directory),
                resume_hint=self.resume_hint,
            ) from error


def _get_app_stem(sweep: Sweep) -> str:
    return app_path(app_name(sweep.request.app_reference)).stem
