"""The segments of a ring recording, and how they become one MCAP file.

During a run, ``run.mcap`` has the metadata of the run, and the folder ``run.mcap.segments`` has the newest chunks in
files of some seconds each. At the end the segments are appended to ``run.mcap``, the oldest first. Each segment is
deleted after it was appended, so the disk holds one segment twice at most. If the process is killed, `join_segments`
continues at the same place.
"""

from __future__ import annotations

import errno
import os
import re
from collections import deque
from contextlib import suppress
from io import FileIO
from pathlib import Path
from typing import NamedTuple

from mcap.opcode import Opcode

from robotcore.errors import RecordingError
from robotcore.files import lock_file, measure_free_space, require_regular, write_all
from robotcore.recording.chunks import MAGIC, RECORD
from robotcore.recording.file_index import write_index

DISK_FULL = (errno.ENOSPC, errno.EDQUOT)
"""The error numbers of a full disk, and of a user's full quota."""

_SEGMENT_NAME = re.compile(r"(\d{8})(\.at-(\d{1,18}))?")
_COPY_BYTES = 2**20
_INDEX_BYTES = 2**17
"""The assumed size of the index of a recording, in bytes."""


class _Segment(NamedTuple):
    file: Path
    begun_at: int | None
    """The offset in the recording at which the copy of this segment has begun; None if it has not begun."""


def locate_segments(path: Path) -> Path:
    """Return the folder of the segments of a recording."""
    return path.with_name(f"{path.name}.segments")


def has_segments(path: Path) -> bool:
    """Return whether a recording has segments, because it is being written or its process was killed."""
    if not path.name:  # a folder such as "."
        return False
    folder = locate_segments(path)
    return folder.is_dir() and not folder.is_symlink()


def remove_segments(path: Path) -> None:
    """Delete the segments of an earlier recording into the same file. Raises OSError."""
    if has_segments(path):
        for segment in _list_segments(path):
            segment.file.unlink()
        with suppress(OSError):  # the user may have put other files there
            locate_segments(path).rmdir()


def join_segments(path: Path) -> None:
    """Join the segments that a killed process has left into their recording. Without a recording, do nothing.

    Raises RecordingError if a run is still writing them, or if the file cannot be written.
    """
    if not has_segments(path):
        return
    try:
        with open_locked(path) as file:
            if file.read(len(MAGIC)) == MAGIC:
                append_segments(path, file)
    except BlockingIOError as error:
        raise build_in_progress_error(path) from error
    except OSError as error:
        raise build_join_error(path, error) from error


def build_in_progress_error(path: Path) -> RecordingError:
    """Return the error for a recording that another process writes."""
    problem, remedy = "a run is still writing the recording", "Wait for its end, or name another file"
    return RecordingError(path, problem, remedy, kind="recording-in-progress")


def build_join_error(path: Path, error: OSError) -> RecordingError:
    """Return the error for segments that cannot be joined, with the cause in ``error``."""
    file, folder = path.name, locate_segments(path).name
    if error.errno == errno.ENOENT:
        remedy = f"{file} or {folder} is missing. Put both into one folder"
    elif error.errno in DISK_FULL:
        remedy = f"Free disk space, or copy {file} and {folder} to another disk"
    else:
        remedy = f"Copy {file} and {folder} to another disk that can be written"
    problem = f"the segments of the recording cannot be joined: {error.strerror}"
    return RecordingError(path, problem, f"{remedy}. Then: robotcore info {file}", kind="segments-not-joined")


def open_locked(path: Path, *, is_new: bool = False) -> FileIO:
    """Open a recording to change it, and lock it until it is closed.

    is_new: whether to create the file if it does not exist.
    Raises BlockingIOError if another process writes the recording, and other OSErrors.
    """

    def open_regular(name: str, flags: int) -> int:
        require_regular(path)
        no_links = getattr(os, "O_NOFOLLOW", 0)  # Windows lacks it
        return os.open(name, flags | no_links | (os.O_CREAT if is_new else 0), 0o666)

    file = open(path, "r+b", buffering=0, opener=open_regular)  # noqa: SIM115  the caller closes it
    try:
        lock_file(file)
    except OSError as error:
        if error.errno not in (errno.ENOTSUP, errno.ENOSYS, errno.ENOLCK):  # some network disks have no locks
            file.close()
            raise
    return file


def append_segments(path: Path, file: FileIO) -> None:
    """Append the segments to the open and locked recording, write its index, and delete them. Raises OSError.

    If the disk has no room for a copy of the largest segment, the oldest segments are deleted first.
    """
    segments = deque(_list_segments(path))
    end = measure_records(file, len(MAGIC))
    if segments and segments[0].begun_at is not None:
        end = min(end, segments[0].begun_at)
    else:
        _make_room(segments, file)
    for segment in segments:
        file.truncate(end)
        begun = segment.file.with_name(f"{segment.file.name[:8]}.at-{end}")
        segment.file.replace(begun)
        end = _append(begun, file, end)
        os.fsync(file.fileno())
        begun.unlink()
    file.truncate(end)
    write_index(file, end)
    os.fsync(file.fileno())
    with suppress(OSError):  # the user may have put other files there
        locate_segments(path).rmdir()


def _make_room(segments: deque[_Segment], file: FileIO) -> None:
    """Delete the oldest segments until the disk has room for a copy of the largest one."""
    while len(segments) > 1:
        if measure_free_space(file) >= max(each.file.stat().st_size for each in segments) + _INDEX_BYTES:
            return
        segments.popleft().file.unlink()


def measure_records(file: FileIO, begin: int) -> int:
    """Return the offset of the end of the last complete record of the data section.

    begin: the offset of the first record.
    """
    size, at = os.fstat(file.fileno()).st_size, begin
    while size - at >= RECORD.size:
        file.seek(at)
        opcode, length = RECORD.unpack(file.read(RECORD.size))
        if opcode in (0, Opcode.DATA_END) or length > size - at - RECORD.size:
            break
        at += RECORD.size + length
    return at


def _append(segment: Path, file: FileIO, at: int) -> int:
    """Copy the complete records of a segment to an offset of the recording. Return the offset of their end."""
    with segment.open("rb", buffering=0) as source:
        left = measure_records(source, 0)
        source.seek(0)
        file.seek(at)
        while left and (data := source.read(min(left, _COPY_BYTES))):
            write_all(file, data)
            left -= len(data)
            at += len(data)
    return at


def _list_segments(path: Path) -> list[_Segment]:
    """Return the segments of a recording, the oldest first. Raises OSError if one is not a regular file."""
    found = []
    for file in sorted(locate_segments(path).iterdir()):
        if name := _SEGMENT_NAME.fullmatch(file.name):
            require_regular(file)
            found.append(_Segment(file, int(name[3]) if name[3] else None))
    return found
