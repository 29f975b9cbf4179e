"""Record a run: an observer puts its ticks into a queue, and a thread writes them to a file."""

from __future__ import annotations

import threading
from collections import deque
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from robotcore.errors import BackendMissingError, RecordingError, RobotcoreError
from robotcore.extras import require_extra
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.recording.complete_ticks import CompleteTicks
from robotcore.recording.mcap_file import McapFile
from robotcore.recording.recording import Metadata, build_metadata
from robotcore.recording.tick_collector import TickCollector
from robotcore.recording.writer import Entry, RecordingWriter
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import RunContext
from robotcore.runtime.trace import TickRecord
from robotcore.threads import start_thread

if TYPE_CHECKING:
    from robotcore.recording.ring import Ring

__all__ = ["Recorder"]

T = TypeVar("T")

QUEUE_BYTES = 32 * 2**20
"""The size of the queue in bytes, which is about 140 pictures of 320 x 240 pixels."""

POLL_S = 0.02
"""The interval at which both threads check the queue, in seconds.

If each tick woke the writer thread, recording a tick would take 2 ms on a busy machine instead of 0.002 ms.
"""


class WriteQueue(Generic[T]):
    """A queue from the control thread to the writer thread. A full queue still accepts entries.

    room: the size of the queue in bytes. A queue that has ended is never full.
    """

    def __init__(self, room: int = QUEUE_BYTES) -> None:
        self._entries: deque[tuple[T, int]] = deque()
        self._ended = threading.Event()
        self._room = room
        self._put_bytes = self._taken_bytes = 0

    def has_room(self) -> bool:
        """Return whether the queue is not full."""
        return self._put_bytes - self._taken_bytes < self._room or self._ended.is_set()

    def put(self, entry: T, size: int, *, is_blocking: bool) -> None:
        """Add an entry of about ``size`` bytes. If ``is_blocking`` is True, wait until the queue has room again."""
        if self._ended.is_set():
            return
        self._put_bytes += size
        self._entries.append((entry, size))
        while is_blocking and not self.has_room() and not self._ended.wait(POLL_S):
            pass

    def end(self) -> None:
        """End the queue: `put` discards further entries, and stops waiting."""
        self._ended.set()

    def get(self) -> T | None:
        """Return the oldest entry; None if the queue is empty, after a wait of `POLL_S` seconds."""
        if not self._entries:
            self._ended.wait(POLL_S)
            return None
        entry, size = self._entries.popleft()
        self._taken_bytes += size
        return entry

    @property
    def is_over(self) -> bool:
        """Whether the queue has ended and is empty."""
        return self._ended.is_set() and not self._entries


FLUSH_S = 0.5
"""The interval of flushes, in seconds, of a ring also on the robot's clock.

A killed process loses the messages since the last flush.
"""

JOIN_S = 60.0
"""The longest wait for the writer thread at the end of a run, in seconds."""


class Recorder:
    """An observer that records a run: ``session.run(request, [recorder], [recorder.layer])``.

    A simulated run waits for a slow disk. A real robot cannot wait, so the recorder then drops pictures.
    If the file cannot be written, the recording ends and the run continues.

    path: the ``.mcap`` file, which is overwritten.
    is_jpeg: whether to write pictures of cameras as JPEGs. Such a recording cannot be replayed.
    limit: the file size at which the recording ends, in bytes. The last chunk and the index come on top of it. With
        ``last_s``, the recording does not end: it keeps what the limit has room for.
    last_s: the time before the end of the run that the recording keeps, in seconds; None for the whole run.
    room: the size of the queue in bytes.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     read(Path(folder, "run.mcap"))
    <Recording of avoid-obstacles on kinematic: 11 ticks, timeout>
    """

    def __init__(
        self,
        path: Path,
        *,
        is_jpeg: bool = False,
        limit: int | None = None,
        last_s: float | None = None,
        room: int = QUEUE_BYTES,
    ) -> None:
        self.failure: RobotcoreError | None = None
        """The error that ended the recording; None if there is none."""
        self.ended_early = ""
        """Why the recording ended before its run; empty if it did not."""
        self._notes: list[str] = []
        self.path, self._is_jpeg, self._limit, self._last_s = path, is_jpeg, limit, last_s
        self._ring: Ring | None = None
        self._ticks = CompleteTicks()
        self._queue: WriteQueue[Entry] = WriteQueue(room)
        self._is_stepped = False
        self._collector = TickCollector(lambda: self._is_stepped or self._queue.has_room())
        self.layer = self._collector.layer
        self._result: RunResult | None = None
        self._thread: threading.Thread | None = None

    def __repr__(self) -> str:
        return f"Recorder({str(self.path)!r}: {self.failure or self.ended_early or 'no failure'})"

    @property
    def has_begun(self) -> bool:
        """Whether the metadata of the run are in the file."""
        return self._thread is not None

    @property
    def is_writing(self) -> bool:
        """Whether the writer thread is alive."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def dropped(self) -> int:
        """The number of dropped pictures."""
        return self.layer.dropped

    @property
    def begins_s(self) -> float | None:
        """The time of the first complete tick in seconds; None if the recording begins with the run."""
        until = self._ring.dropped_until_s if self._ring else None
        return None if until is None else self._ticks.find_begin(until)

    def complete(self, result: RunResult) -> RunResult:
        """Return the result with the number of dropped pictures, and notes about the content that the file lacks."""
        return replace(result, dropped_pictures=self.dropped, notes=[*result.notes, *self._notes])

    def begin(self, run: RunContext) -> None:
        """Open the file, write the metadata, and start the writer thread."""
        metadata = self._build_metadata(run)
        self._is_stepped = run.robot.clock.is_lockstep
        self._collector.begin(run)
        file = None
        try:
            file = self._open_file()
            writer = RecordingWriter(file, run, metadata, is_jpeg=self._is_jpeg, notes=self._notes)
        except Exception as error:  # noqa: BLE001  any error must end only the recording, not the run
            self._set_failure(error)
        else:
            self._thread = start_thread(partial(self._write, file, writer), "recorder")
        finally:
            if file and not self._thread:
                self._close(file)

    def _open_file(self) -> McapFile:
        if self._last_s is None:
            return McapFile(self.path)
        require_extra("record", "a recording")
        from robotcore.recording.ring import Ring

        self._ring = Ring(self.path, self._last_s, self._limit)
        return McapFile(self.path, self._ring)

    def tick(self, record: TickRecord) -> None:
        """Put a tick into the queue."""
        entry = self._collect(record)
        self._queue.put(entry, entry.size, is_blocking=self._is_stepped)

    def end(self, result: RunResult) -> None:
        """Let the writer thread write the result, and wait for its end."""
        self._result = result
        self._queue.end()
        if self._thread:
            self._thread.join(JOIN_S)
            if self._thread.is_alive():
                self._set_failure(self._build_late_error())

    def _build_late_error(self) -> RecordingError:
        if self._ring:
            problem = f"the segments were not joined within {JOIN_S:g} s"
            return RecordingError(
                self.path, problem, f"Finish it: robotcore info {self.path}", kind="segments-not-joined"
            )
        problem = f"the disk has not responded for {JOIN_S:g} s"
        return RecordingError(self.path, problem, "Use another disk", kind="disk-hangs")

    def _build_metadata(self, run: RunContext) -> Metadata:
        return build_metadata(run)

    def _collect(self, record: TickRecord) -> Entry:
        return self._collector.collect(record)

    def _write(self, file: McapFile, writer: RecordingWriter) -> None:
        try:
            self._write_all(file, writer)
            file.close()
        except BaseException as error:  # noqa: BLE001  also a panic of the library, because the run waits for this thread
            self._set_failure(error)
        finally:
            self._close(file)

    def _write_all(self, file: McapFile, writer: RecordingWriter) -> None:
        clock, due, unsaved = MonotonicClock(), 0.0, 0  # due at once, so that a crash leaves a file with a tick
        robot_due = inf
        while not self._queue.is_over:
            if entry := self._queue.get():
                writer.write(entry)
                unsaved += 1
                if self._ring:
                    self._ticks.add(entry.record.time, entry.events, self._ring.dropped_until_s)
                    # a ring loses little of a fast simulation, and has short segments
                    robot_due = min(robot_due, entry.record.time + FLUSH_S)
                if self._limit is not None and self._last_s is None and file.size >= self._limit:
                    self._end_early(writer, entry)
                    return
            if unsaved and (clock.now() >= due or (entry and entry.record.time >= robot_due)):
                file.flush()
                due, unsaved, robot_due = clock.now() + FLUSH_S, 0, inf
        if self._result:
            writer.end(self.complete(self._result))
            file.flush()

    def _end_early(self, writer: RecordingWriter, last: Entry) -> None:
        size, time = f"{(self._limit or 0) / 1e6:g} MB", f"{last.record.time:.1f} s"
        self.ended_early = f"the recording reached its size limit of {size} at {time}, before the end of the run"
        writer.end_early(self.ended_early)
        self._queue.end()

    def _close(self, file: McapFile) -> None:
        with suppress(RecordingError):
            file.close()

    def _set_failure(self, error: BaseException) -> None:
        """End the recording with its first error."""
        if not isinstance(error, (RecordingError, BackendMissingError)):
            problem = f"{type(error).__name__}: {error}"
            error = RecordingError(self.path, problem, "Report it as a bug", kind="recorder-bug")
        self.failure = self.failure or error
        self._queue.end()
