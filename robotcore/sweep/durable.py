"""Files that survive a crash: a journal of lines, and files that are replaced in whole."""

from __future__ import annotations

import fcntl
import mmap
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from io import FileIO
from pathlib import Path
from typing import Any, TextIO

from robotcore.errors import UsageError


class Journal:
    """Lines of UTF-8, added one by one, each on the disk before the next. Raises OSError."""

    def __init__(self, file: FileIO) -> None:
        self._file = file

    @classmethod
    def open(cls, path: Path) -> Journal:
        """Open a file for this process alone, without a last line that was cut short.

        Does not wait: UsageError if another process adds to it.
        """
        with ExitStack() as on_failure:
            file = on_failure.enter_context(FileIO(path, "a+"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise UsageError(
                    f"{path.parent}: another sweep is writing there. Wait for it, or stop it",
                    kind="sweep-locked",
                    directory=str(path.parent),
                ) from error
            _drop_torn_line(file)
            on_failure.pop_all()
        return cls(file)

    def add(self, line: str) -> None:
        """Write a line in whole or, where the disk is full, not at all."""
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
        """Drop every line."""
        self._file.truncate(0)

    def close(self) -> None:
        """Let others add. May be called again."""
        self._file.close()


def _drop_torn_line(file: FileIO) -> None:
    """Drop what stands after the last line feed: a process was killed over it."""
    if size := file.seek(0, os.SEEK_END):
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            whole = content.rfind(b"\n") + 1
        if whole < size:  # a file that is cut to the length it has counts as changed
            file.truncate(whole)


def part_path(file: Path) -> Path:
    """Return what a file is called while it is written."""
    return file.with_name(f"{file.name}.part")


@contextmanager
def replace_text(file: Path, **how: Any) -> Iterator[TextIO]:
    """Give a text file to write, in UTF-8; it takes the place of ``file`` once it is on the disk.

    ``how`` goes to `open`. Leaves nothing behind if writing fails with an OSError.
    """
    part = part_path(file)
    try:
        with part.open("w", encoding="utf-8", **how) as text:
            yield text
            text.flush()
            os.fsync(text.fileno())
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
