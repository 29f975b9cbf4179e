"""Write an MCAP file: channels, attachments and metadata."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from io import FileIO
from pathlib import Path
from typing import Protocol

from robotcore.errors import RecordingError
from robotcore.extras import require_extra
from robotcore.files import require_replaceable, write_all
from robotcore.recording.channel_output import ChannelOutput

CHUNK_BYTES = 2**20
"""The size of a chunk before compression, in bytes. A reader must unpack a whole chunk to read one picture."""

ROOM = "Free disk space, or name a file on another disk"
"""The remedy if a file cannot be written."""


class McapFile(ChannelOutput):
    """Writes an MCAP file with foxglove-sdk: compressed chunks of messages, with checksums.

    The first write error raises RecordingError. Nothing is written after it. If the process crashes, only the messages
    since the last flush are lost.

    path: the file, which is overwritten.
    sink: the file object that receives the bytes; None for one that writes all bytes to the file.
    """

    def __init__(self, path: Path, sink: Sink | None = None) -> None:
        require_extra("record", "a recording")
        import foxglove
        from foxglove.mcap import MCAPWriteOptions

        self._path = path
        self._sink = sink or _PlainSink(path)
        super().__init__()
        options = MCAPWriteOptions(
            chunk_size=CHUNK_BYTES, compression_level=1, compression_threads=0, disable_seeking=True
        )
        self._writer = foxglove.open_mcap(self._sink, context=self.context, writer_options=options)

    @property
    def size(self) -> int:
        """The number of bytes in the file so far, without the unfinished chunk."""
        return self._sink.size

    def attach(self, name: str, media_type: str, content: bytes) -> None:
        self._try(
            lambda: self._writer.attach(log_time=0, create_time=0, name=name, media_type=media_type, data=content)
        )

    def write_metadata(self, name: str, entries: Mapping[str, str]) -> None:
        self._try(lambda: self._writer.write_metadata(name, dict(entries)))

    def flush(self) -> None:
        """Write all messages to the file. Raises RecordingError if the file cannot be written."""
        self._try(self._writer.flush)

    def close(self) -> None:
        """Write the index, and close the file. Later calls do nothing."""
        try:
            self._try(self._writer.close)
        finally:
            self._sink.close()

    def _try(self, write: Callable[[], None]) -> None:
        try:
            write()
        except Exception as error:
            raise RecordingError(
                self._path, f"the file cannot be written: {error}", ROOM, kind="file-not-writable"
            ) from error
        if cause := self._sink.error:
            raise RecordingError(self._path, str(cause.strerror), ROOM, kind="file-not-writable") from cause


class Sink(Protocol):
    """A file object to which foxglove-sdk writes. It stores the first error instead of raising it."""

    error: OSError | None

    @property
    def size(self) -> int:
        """The size of the file, in bytes."""

    def write(self, data: bytes | bytearray) -> int:
        """Append bytes."""

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Return the position."""

    def flush(self) -> None:
        """Write buffered bytes, if there are any."""

    def close(self) -> None:
        """Close the file. Raises RecordingError. Later calls do nothing."""


class _PlainSink:
    """The file object to which foxglove-sdk writes.

    `write` stores the first error in ``error`` instead of raising it, and then discards all bytes. If it raised the
    error, foxglove-sdk would print the error for each message.
    """

    def __init__(self, path: Path) -> None:
        self._file = create_recording(path)
        self.error: OSError | None = None
        self.size = 0

    def write(self, data: bytes | bytearray) -> int:
        if not self.error:
            try:
                write_all(self._file, data)
            except OSError as error:
                self.error = error
        self.size += len(data)
        return len(data)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Return the position. The writer appends only."""
        return self.size

    def flush(self) -> None:
        """Do nothing. The file has no buffer."""

    def close(self) -> None:
        self._file.close()


def create_recording(path: Path) -> FileIO:
    """Open and lock an empty recording. Delete the content and the segments of an earlier one.

    Raises RecordingError if another process writes the recording, or if the file cannot be written.
    """
    from robotcore.recording.segments import build_in_progress_error, open_locked, remove_segments

    try:
        file = open_locked(path, is_new=True)
    except BlockingIOError as error:
        raise build_in_progress_error(path) from error
    except OSError as error:
        raise build_unwritable_error(path, error) from error
    try:
        remove_segments(path)
        file.truncate(0)
    except OSError as error:
        file.close()
        raise build_unwritable_error(path, error) from error
    return file


def require_recordable(path: Path, *, is_forced: bool = False) -> None:
    """Raise RecordingError if a recording cannot be written to this file. The file itself does not change.

    is_forced: whether an existing recording may be overwritten.
    """
    require_extra("record", "a recording")
    from robotcore.recording.segments import has_segments

    if path.suffix.lower() != ".mcap":
        raise RecordingError(path, "the name of a recording must end in .mcap", "Name another file", kind="file-ending")
    try:
        require_replaceable(path)
    except OSError as error:
        raise build_unwritable_error(path, error) from error
    if not is_forced and has_segments(path):
        raise RecordingError(
            path,
            "the file has the recording of a killed run",
            f"Finish it: robotcore info {path}. Or name another file, or overwrite it with --force",
            kind="recording-not-finished",
        )
    if not is_forced and path.exists() and path.stat().st_size:
        raise RecordingError(
            path, "the file exists", "Name another file, or overwrite it with --force", kind="recording-exists"
        )


def build_unwritable_error(path: Path, error: OSError) -> RecordingError:
    """Return the error for a file that cannot be written, with the cause in ``error``."""
    return RecordingError(
        path,
        str(error.strerror),
        "Name a file that can be written, on a disk with free space",
        kind="file-not-writable",
    )
