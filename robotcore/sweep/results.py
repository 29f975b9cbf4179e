"""The results folder of a sweep: add records, read them, and list the missing runs."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime, timezone
from functools import cached_property
from pathlib import Path
from types import TracebackType

from robotcore.description import load_world
from robotcore.errors import UsageError
from robotcore.files import find_parts, replace_file, replace_text
from robotcore.runtime.apps import app_name, app_path
from robotcore.runtime.plan import RunRequest
from robotcore.sweep.fingerprint import MANIFEST, collect_dependencies, compute_digest, format_manifest, require_same
from robotcore.sweep.record import Record
from robotcore.sweep.results_file import Journal, RunKey, get_run_key, read_results
from robotcore.sweep.single_run import RunOutput
from robotcore.sweep.spec import Sweep, format_seeds
from robotcore.sweep.tables import FAILURES, TABLE, are_current, write_tables

RESULTS, PICTURES = "results.jsonl", "failures"
_DISK_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


class Results:
    """The results of a sweep in a folder. ``with`` locks the folder, so only one process at a time can add results.

    The folder may have results for other seeds too. They stay in the folder, and no method returns them.

    `add` returns after the record is on the disk. So no added record is lost if the sweep is killed.

    >>> from pathlib import Path
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

    def __init__(self, sweep: Sweep, directory: Path | None = None, *, deletes_old_results: bool = False) -> None:
        """Store the arguments. Nothing is written before the ``with`` statement.

        sweep: the sweep of the results.
        directory: the folder. None means ``sweeps/<app>-<digest>``.
        deletes_old_results: whether ``with`` deletes all results in the folder, including those of other seeds.
        """
        self.sweep, self._directory, self._fresh = sweep, directory, deletes_old_results
        self._journal: Journal | None = None

    def __repr__(self) -> str:
        return f"Results({self.sweep!r}, {self._directory!r})"

    @cached_property
    def directory(self) -> Path:
        """The folder of the results."""
        app = app_path(app_name(self.sweep.request.app_reference)).stem
        return self._directory or Path("sweeps") / f"{app}-{compute_digest(self._dependencies)[:8]}"

    @cached_property
    def _dependencies(self) -> dict[str, dict[str, object]]:
        return collect_dependencies(self.sweep)

    @cached_property
    def _requests(self) -> dict[RunKey, RunRequest]:
        """The request of each run of the sweep."""
        worlds = {world: load_world(world).name for world in self.sweep.worlds}
        return {
            (request.backend, worlds[request.world or ""], request.seed): request for request in self.sweep.requests()
        }

    def __enter__(self) -> Results:
        try:
            self.directory.mkdir(parents=True, exist_ok=True)
            self._require_sweep_or_empty()
            self._journal = Journal(self.directory / RESULTS)
            try:
                self._claim_folder(self._journal)
            except BaseException:
                self._journal.close()
                raise
        except OSError as error:
            problem = "it is not a folder" if isinstance(error, FileExistsError) else error.strerror
            raise UsageError(
                f"{error.filename or self.directory}: {problem}. No run was executed. "
                "Name a writable folder with --out",
                kind="unusable-folder",
                directory=str(self.directory),
            ) from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._journal:
            self._journal.close()
            self._journal = None

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
        return read_results(file, self._requests.keys()) if file.exists() else iter(())

    def missing(self) -> list[RunRequest]:
        """Return the runs of this sweep that have no record yet."""
        done = set(map(get_run_key, self.records()))
        return [request for key, request in self._requests.items() if key not in done]

    def add(self, output: RunOutput) -> Record:
        """Write the picture and the record of a run, and return the record. Raises UsageError if the disk is full."""
        assert self._journal, "results are added inside with"
        record, result = output.record, output.record.result
        with self._report_write_errors():
            if output.picture is not None:
                name = f"{PICTURES}/{result.backend}-{result.world}-{result.seed}.png"
                (self.directory / PICTURES).mkdir(exist_ok=True)
                with replace_file(self.directory / name) as part:
                    part.write_bytes(output.picture)
                record = replace(record, picture=name)
            self._journal.append(record.to_json())
        return record

    def write_tables(self) -> None:
        """Write the tables ``results.csv`` and ``failures.csv``, unless they are newer than the results."""
        if not are_current(self.directory, self.directory / RESULTS):
            with self._report_write_errors():
                write_tables(self.directory, self.records)

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

    def _claim_folder(self, journal: Journal) -> None:
        for folder in (self.directory, self.directory / PICTURES):
            for part in find_parts(folder) if folder.is_dir() else ():
                part.unlink()
        manifest, content = (
            self.directory / MANIFEST,
            format_manifest(self._dependencies, format_seeds(self.sweep.seeds)),
        )
        if self._fresh:
            journal.clear()
            for file in (self.directory / PICTURES).glob("*.png"):
                file.unlink()
        elif manifest.exists():
            require_same(self.directory, self._dependencies)
        if not manifest.exists() or manifest.read_bytes() != content.encode():
            for name in (TABLE, FAILURES):
                (self.directory / name).unlink(missing_ok=True)
            with replace_text(manifest) as text:
                text.write(content)

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
