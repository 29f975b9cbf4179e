"""What waits to be written: bounded, so that a slow disk costs a robot pictures and not its memory."""

from __future__ import annotations

import threading
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")

ROOM_BYTES = 32 * 2**20
"""About 140 pictures of 320 x 240."""


class Backlog(Generic[T]):
    """A queue between the control thread and one that writes. Whoever puts may be let wait, but nothing is refused."""

    def __init__(self, room: int = ROOM_BYTES) -> None:
        self._entries: deque[tuple[T, int]] = deque()
        self._changed = threading.Condition()
        self._room = room
        self._size = 0
        self._is_ended = False

    def has_room(self) -> bool:
        """Return whether more pictures may be put."""
        return self._size < self._room

    def put(self, entry: T, size: int, *, waits: bool) -> None:
        """Hand over an entry of about ``size`` bytes; if ``waits``, return only when there is room again."""
        with self._changed:
            if self._is_ended:
                return
            self._entries.append((entry, size))
            self._size += size
            self._changed.notify_all()
            while waits and self._size >= self._room and not self._is_ended:
                self._changed.wait()

    def end(self) -> None:
        """Take no more; whoever waits goes on."""
        with self._changed:
            self._is_ended = True
            self._changed.notify_all()

    def get(self, timeout: float) -> T | None:
        """Return the oldest entry, or None where there is none for ``timeout`` seconds."""
        with self._changed:
            if not self._entries and not self._is_ended:
                self._changed.wait(max(timeout, 0.0))
            if not self._entries:
                return None
            entry, size = self._entries.popleft()
            self._size -= size
            self._changed.notify_all()
            return entry

    @property
    def is_over(self) -> bool:
        """Whether it was ended, and all of it taken."""
        return self._is_ended and not self._entries
