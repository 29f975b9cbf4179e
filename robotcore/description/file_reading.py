"""Reads the files of descriptions, with a limit of their size."""

from __future__ import annotations

from pathlib import Path
from stat import S_ISDIR, S_ISREG

from robotcore.errors import UsageError


def read_limited(path: Path, limit: int) -> bytes:
    """Return the content of a regular file.

    limit: the greatest size of the file, in bytes.

    Raises UsageError if the file cannot be read or is larger.
    """
    try:
        _require_readable(path, limit)
        return path.read_bytes()
    except UsageError:
        raise
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}. Name a file that can be read", kind="unreadable-file") from error
    except ValueError as error:
        text = f"{str(path)!r} is not a path: {error}. Name a file that can be read"
        raise UsageError(text, kind="unreadable-file") from error


def _require_readable(path: Path, limit: int) -> None:
    status = path.stat()
    if not (S_ISREG(status.st_mode) or S_ISDIR(status.st_mode)):  # reading a folder raises OSError
        raise UsageError(f"{path}: it is a device or a pipe. Name a file that can be read", kind="no-regular-file")
    if S_ISREG(status.st_mode) and status.st_size > limit:
        raise UsageError(
            f"{path}: it has {status.st_size} bytes, and the limit is {limit}. Name a smaller file",
            kind="file-too-large",
            bytes=status.st_size,
            limit=limit,
        )
