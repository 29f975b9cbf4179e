"""The file ``results.jsonl`` of a sweep: append lines that survive a crash, and read the records."""

from __future__ import annotations

import mmap
import os
from collections.abc import Container, Iterator
from io import FileIO
from pathlib import Path

from robotcore.errors import UsageError
from robotcore.files import lock_file
from robotcore.sweep.record import Record


class Journal:
    """A locked file of UTF-8 lines, open for appending. Deletes an incomplete last line when it is opened.

    Does not wait for the lock: raises UsageError if another process has locked the file. The methods raise OSError if
    the file cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._file = FileIO(path, "a+")
        try:
            lock_file(self._file)
            _delete_incomplete_line(self._file)
        except BlockingIOError as error:
            self.close()
            raise UsageError(
                f"{path.parent}: another sweep is writing to this folder. Wait for its end, or stop it",
                kind="sweep-locked",
                directory=str(path.parent),
            ) from error
        except OSError:
            self.close()
            raise

    def append(self, line: str) -> None:
        """Append a line, and wait until it is on the disk. If the disk is full, the file keeps its old content."""
        content = line.encode() + b"\n"
        size, written = self._file.seek(0, os.SEEK_END), 0
        try:
            while written < len(content):
                written += self._file.write(content[written:])
        finally:
            if written < len(content):
                self._file.truncate(size)
        os.fsync(self._file.fileno())

    def clear(self) -> None:
        """Delete every line."""
        self._file.truncate(0)

    def close(self) -> None:
        """Close the file, and release its lock. Further calls of `close` do nothing."""
        self._file.close()


def _delete_incomplete_line(file: FileIO) -> None:
    """Delete the bytes after the last line feed. A process that was killed while it wrote has left them."""
    if size := file.seek(0, os.SEEK_END):
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            whole = content.rfind(b"\n") + 1
        if whole < size:  # truncating a file to its own length would change its date
            file.truncate(whole)


RunKey = tuple[str, str | None, int | None]
"""The identity of a run within its sweep: its backend, the name of its world and its seed."""


def get_run_key(record: Record) -> RunKey:
    """Return the key of a record's run."""
    return record.result.backend, record.result.world, record.result.seed


def read_results(file: Path, wanted: Container[RunKey]) -> Iterator[Record]:
    """Yield the records of a sweep in a results file, in the file's order.

    wanted: the keys of the runs of the sweep. Other records are skipped.

    Raises UsageError, with the number of the line, if a line is not a record or if a run has two lines.
    """
    seen: set[RunKey] = set()
    with file.open("rb") as lines:
        for number, line in enumerate(lines, 1):
            where = f"{file}, line {number}"
            try:
                record = Record.from_json(line)
            except ValueError as error:
                problem = f"{where}: {error}. Delete the line, and the sweep repeats its run"
                raise UsageError(problem, kind="bad-record", where=where) from error
            if (run := get_run_key(record)) in wanted:
                if run in seen:
                    name = "{}, {}, seed {}".format(*run)
                    problem = f"{where}: the run {name} has a line already. Delete one of the two lines"
                    raise UsageError(problem, kind="duplicate-run", where=where)
                seen.add(run)
                yield record
