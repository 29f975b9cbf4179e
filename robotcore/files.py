"""Replaces files so that a failure leaves the old content in place, and locks files."""

from __future__ import annotations

import errno
import os
import re
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from secrets import token_hex
from typing import Any, TextIO

from robotcore.errors import UsageError
from robotcore.system import HAS_POSIX

_LOCKED_AT = 2**40
"""The offset of the byte that `lock_file` locks on Windows. It is behind the end of every real file.

A lock of Windows excludes other programs from the bytes themselves, and readers need the content.
"""

_PART_NAME = re.compile(r"\.[0-9a-f]{16}(\.\w+)?")


@contextmanager
def replace_file(file: Path) -> Iterator[Path]:
    """Yield the path of a new empty file, which replaces ``file`` at the end of the ``with`` block.

    If the block raises an exception, the new file is deleted and ``file`` keeps its content.

    Raises OSError if the new file cannot be created, or if ``file`` is a link, a FIFO or a device.

    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "map.txt")
    ...     with replace_file(file) as part:
    ...         _ = part.write_text("a wall")
    ...     file.read_text()
    'a wall'
    """
    part = _make_part(file)
    try:
        yield part
        part.replace(file)
    except OSError as error:
        if str(error.filename) == str(part):
            error.filename = str(file)
        raise
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def replace_text(file: Path, **how: Any) -> Iterator[TextIO]:
    """Yield a new text file in UTF-8, which replaces ``file`` at the end of the ``with`` block.

    The new file is synced to the disk before it replaces ``file``. Raises the errors of `replace_file`.

    how: keyword arguments of `open`.
    """
    with replace_file(file) as part, part.open("w", encoding="utf-8", **how) as text:
        yield text
        text.flush()
        os.fsync(text.fileno())


def find_parts(folder: Path) -> list[Path]:
    """Return the unfinished files that killed processes have left in a folder during `replace_file`."""
    return [file for file in folder.iterdir() if _PART_NAME.fullmatch(file.name)]


def require_replaceable(file: Path) -> None:
    """Raise OSError if `replace_file` could not replace a file. The file itself does not change."""
    if file.exists() and not os.access(file, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    _make_part(file).unlink()


def save_output(content: bytes, file: Path, label: str) -> None:
    """Replace a file. If it cannot be written, keep the old file and raise UsageError.

    label: the first words of the error, in front of the file; ``""`` for none.
    """
    try:
        with replace_file(file) as part:
            part.write_bytes(content)
    except OSError as error:
        raise _build_unwritable_error(file, error, label) from None


def require_writable(file: Path, label: str, suffix: str = "") -> None:
    """Raise UsageError if a file has another suffix or cannot be replaced. The check does not change the file.

    label: as for `save_output`.
    suffix: the suffix that the file must have, such as ``.png``; ``""`` for any.
    """
    if suffix and file.suffix.lower() != suffix:
        text = f"{label} {file}: not a {suffix} file. Name a {suffix} file"
        raise UsageError(text.lstrip(), kind="file-ending")
    try:
        require_replaceable(file)
    except OSError as error:
        raise _build_unwritable_error(file, error, label) from None


def _build_unwritable_error(file: Path, error: OSError, label: str) -> UsageError:
    problem, remedy = error.strerror, "Name a file that you can write, on a disk with free space"
    if isinstance(error, FileNotFoundError):
        problem, remedy = f"there is no folder {file.parent}", "Make it, or name another file"
        if is_working_folder_deleted(file):
            problem, remedy = "the working folder has been deleted", "Change to another folder with cd"
    text = f"{label} {file}: {problem}. {remedy}"
    return UsageError(text.lstrip(), kind="file-not-writable", file=str(file))


def is_working_folder_deleted(file: Path) -> bool:
    """Return whether a path is relative to a working folder that has been deleted."""
    if file.is_absolute():
        return False
    try:
        Path.cwd()
    except FileNotFoundError:
        return True
    return False


def _make_part(file: Path) -> Path:
    # The new file has the suffix of `file`, because some libraries choose a format by the suffix.
    mode = require_regular(file)
    part = file.with_name(f".{token_hex(8)}{file.suffix}")  # matches _PART_NAME
    try:
        opened = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666 if mode is None else 0o600)
    except OSError as error:
        error.filename = str(file)
        raise
    try:
        if mode is not None and HAS_POSIX:  # Windows has no permission bits
            os.fchmod(opened, mode)
    finally:
        os.close(opened)
    return part


def require_regular(file: Path) -> int | None:
    """Return the permission bits of a file; None if it does not exist. Raises OSError if it is not a regular file."""
    try:
        mode = file.lstat().st_mode
    except FileNotFoundError:
        return None
    if stat.S_ISLNK(mode):
        raise OSError(errno.ELOOP, "it is a symbolic link")
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "it is not a regular file")
    return mode & 0o777


def write_all(file: FileIO, data: bytes | bytearray) -> None:
    """Write all bytes to a file without a buffer. Raises OSError."""
    left = memoryview(data)
    while left:
        left = left[file.write(left) :]


def lock_file(file: FileIO) -> None:
    """Lock an open file until it is closed. Other programs can read it.

    Raises BlockingIOError if another program has locked the file, and other OSErrors, such as on a disk without locks.
    """
    if HAS_POSIX:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return
    import msvcrt

    at = file.seek(0, os.SEEK_CUR)
    file.seek(_LOCKED_AT)
    try:
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    except PermissionError as error:
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN)) from error
    finally:
        file.seek(at)


def measure_free_space(file: FileIO) -> int:
    """Return the free space of the disk of an open file, in bytes."""
    return shutil.disk_usage(file.fileno() if HAS_POSIX else file.name).free
