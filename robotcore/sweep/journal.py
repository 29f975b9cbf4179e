"""A file of lines that one process adds to, and that a process which is killed leaves whole."""

from __future__ import annotations

import fcntl
import mmap
import os
from pathlib import Path

from robotcore.errors import UsageError


class Journal:
    """Lines of UTF-8, added one by one; opening it waits for nobody. OSError is the caller's to tell."""

    def __init__(self, path: Path) -> None:
        """Open the file for this process alone; UsageError where another one adds to it."""
        self._path = path
        self._file = path.open("ab+", buffering=0)
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._drop_torn_line()
        except BlockingIOError as error:
            self.close()
            raise UsageError(f"{path.parent}: another sweep is writing there. Wait for it, or stop it") from error
        except OSError:
            self.close()
            raise

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

    def forget(self) -> None:
        """Drop every line."""
        self._file.truncate(0)

    def close(self) -> None:
        """Let others add. May be called again."""
        self._file.close()

    def _drop_torn_line(self) -> None:
        """Drop what stands after the last line feed: a process was killed over it."""
        if self._file.seek(0, os.SEEK_END):
            with mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ) as content:
                whole = content.rfind(b"\n") + 1
            self._file.truncate(whole)
