"""Incoming recordings of a robot, kept in a separate folder until each is a whole plain file."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from robotcore.deploy.agent.files import format_bytes, measure_free_space, measure_size
from robotcore.errors import DeployError, UsageError
from robotcore.text import escape

RESERVED_DISK_BYTES = 500_000_000
"""The bytes that stay free on the disk of the desk."""

SLACK_BYTES = 1 << 20
"""The most bytes that folders and blocks of a disk take besides the recordings."""

PARTIAL = ".partial"
"""The folder beside the recordings that keeps an incomplete file when a connection breaks."""


class IncomingFiles:
    """A temporary folder for incoming files.

    On exit, files of the stated size move into ``folder``, and all others are deleted. An error is such an exit too.
    ``sizes`` has the bytes of each requested recording, as the robot states them.
    """

    def __init__(self, folder: Path, sizes: Mapping[str, int]) -> None:
        self._folder, self._sizes = folder, sizes
        self.received: list[str] = []

    def __enter__(self) -> IncomingFiles:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._require_room(sum(self._sizes.values()))
            self._remove_leftovers()
            self.partial.mkdir(mode=0o700, exist_ok=True)
            self.path = Path(tempfile.mkdtemp(prefix=".arriving-", dir=self._folder))
        except OSError as error:
            problem = f"{escape(str(self._folder))} cannot be made or written to: {error.strerror}"
            raise UsageError(f"{problem}. Take another folder: -o DIR") from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        try:
            self.received = sorted(name for name in self._sizes if self._accept(name))
        finally:
            shutil.rmtree(self.path, ignore_errors=True)
            self._remove_leftovers()
            with suppress(OSError):
                self.partial.rmdir()

    @property
    def partial(self) -> Path:
        """The folder for incomplete files."""
        return self._folder / PARTIAL

    @property
    def missing(self) -> list[str]:
        """The recordings that did not come as plain files of the stated size. It is complete after the exit."""
        return sorted(self._sizes.keys() - {*self.received})

    def check_limits(self) -> None:
        """Raise DeployError if more bytes came than the robot stated, or if this machine's disk is nearly full."""
        stated = sum(self._sizes.values())
        if measure_size(self.path) > stated + SLACK_BYTES:
            raise DeployError(
                f"the robot sends more than the {format_bytes(stated)} that it stated. "
                "Check that this is the right robot"
            )
        self._require_room(0)

    def _require_room(self, size: int) -> None:
        free = measure_free_space(self._folder.absolute())
        if size + RESERVED_DISK_BYTES > free:
            raise DeployError(
                f"not enough room: the recordings need {format_bytes(size)}, the disk has {format_bytes(free)} free, "
                f"and {format_bytes(RESERVED_DISK_BYTES)} must stay free. Make room, or name a folder on another disk: "
                "-o DIR"
            )

    def _remove_leftovers(self) -> None:
        """Delete links and foreign files from the folder of incomplete files: rsync would write through a link."""
        if self.partial.is_symlink():
            self.partial.unlink()
        for path in self.partial.iterdir() if self.partial.is_dir() else ():
            if _is_plain(path) and path.lstat().st_size <= self._sizes.get(path.name, -1):
                continue
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink()

    def _accept(self, name: str) -> bool:
        """Move a plain file of the stated size into the folder; return whether it moved."""
        file, target = self.path / name, self._folder / name
        if not _is_plain(file) or file.lstat().st_size != self._sizes[name] or os.path.lexists(target):
            return False
        with suppress(OSError):  # a disk of Windows has no such modes
            file.chmod(file.lstat().st_mode & 0o644)
        file.rename(target)
        return True


def _is_plain(path: Path) -> bool:
    """Return whether the path is a regular file: no link, no folder and no device."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:
        return False
