"""What waits to be written: bounded, so that a slow disk costs a robot pictures and not its memory."""

from __future__ import annotations

import threading
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")

ROOM_BYTES = 32 * 2**20
"""About 140 pictures of 320 x 240."""

NAP_S = 0.02
"""How often each side looks what the other has done. To wake a thread at each tick would cost the tick more than all
else of a recording: 2 ms on a busy machine, instead of 0.002."""


class Backlog(Generic[T]):
    """A queue from the control thread to one that writes. Whoever puts may be let wait, but nothing is refused."""

    def __init__(self, room: int = ROOM_BYTES) -> None:
        self._entries: deque[tuple[T, int]] = deque()
        self._ended = threading.Event()
        self._room = room
        self._put_bytes = self._taken_bytes = 0

    def has_room(self) -> bool:
        """Return whether more pictures may be put."""
        return self._put_bytes - self._taken_bytes < self._room

    def put(self, entry: T, size: int, *, waits: bool) -> None:
        """Hand over an entry of about ``size`` bytes; if ``waits``, return only when there is room again."""
        if self._ended.is_set():
            return
        self._put_bytes += size
        self._entries.append((entry, size))
        while waits and not self.has_room() and not self._ended.wait(NAP_S):
            pass

    def end(self) -> None:
        """Take no more; whoever waits goes on."""
        self._ended.set()

    def abandon(self) -> None:
        """Take no more, and let go of what nobody takes any more: there is room again. For who gets, alone."""
        self.end()
        while not self.is_over:
            self.get()

    def get(self) -> T | None:
        """Return the oldest entry, or after a nap None if there is none."""
        if not self._entries:
            self._ended.wait(NAP_S)
            return None
        entry, size = self._entries.popleft()
        self._taken_bytes += size
        return entry

    @property
    def is_over(self) -> bool:
        """Whether it was ended, and all of it taken."""
        return self._ended.is_set() and not self._entries
