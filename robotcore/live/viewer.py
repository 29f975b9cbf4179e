"""A viewer of the page: the messages that wait for it, and its limits."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import Protocol

from starlette.websockets import WebSocket

MAX_MESSAGES = 600
"""A viewer for whom more messages wait is dropped."""

MAX_OPEN_TICKS = 3
"""The number of ticks that a viewer has not acknowledged, before the next ones are skipped."""

SENDING_S = 5.0
"""A viewer who does not read a message for this time, in seconds, is dropped."""


class Source(Protocol):
    """The newest state of the run."""

    tick: bytes
    pictures: dict[str, bytes]


class Viewer:
    """Sends the newest state to one viewer, as fast as the viewer reads it.

    Ticks and pictures that are too old are skipped. The other messages are sent in their order.
    """

    def __init__(self, socket: WebSocket, source: Source) -> None:
        self._socket, self._source = socket, source
        self._messages: deque[bytes] = deque()
        self._pictures: dict[str, None] = {}
        self._open_pictures: set[str] = set()
        self._has_tick, self._open_ticks = False, 0
        self._wake, self.is_done = asyncio.Event(), asyncio.Event()
        self.is_ending = False
        """Whether the viewer leaves because the run has ended."""
        self.is_dropped = False

    def add_message(self, text: bytes) -> None:
        """Send a message after those that wait already."""
        self._messages.append(text)
        self.is_dropped |= len(self._messages) > MAX_MESSAGES
        self._wake.set()

    def add_tick(self) -> None:
        """Send the newest tick when the viewer can take it."""
        self._has_tick = True
        self._wake.set()

    def add_picture(self, name: str) -> None:
        """Send the newest picture of a name when the viewer can take it."""
        self._pictures[name] = None
        self._wake.set()

    def acknowledge_tick(self) -> None:
        """Note that the viewer has drawn a tick."""
        self._open_ticks = max(0, self._open_ticks - 1)
        self._wake.set()

    def acknowledge_picture(self, name: str) -> None:
        """Note that the viewer has drawn a picture."""
        self._open_pictures.discard(name)
        self._wake.set()

    async def send_all(self) -> None:
        """Send messages until the viewer leaves or does not read. Raises TimeoutError then."""
        try:
            while not (self.is_dropped or self.is_ending):
                await self._wake.wait()
                self._wake.clear()
                await self._send_pending()
        finally:
            self.is_done.set()

    def end(self) -> None:
        """Let `send_all` return after it has sent the messages that wait."""
        self.is_ending = True
        self._wake.set()

    async def _send_pending(self) -> None:
        while self._messages:
            await self._send(self._messages.popleft())
        if self._has_tick and self._source.tick and self._open_ticks < MAX_OPEN_TICKS:
            self._has_tick = False
            self._open_ticks += 1
            await self._send(self._source.tick)
        for name in [name for name in self._pictures if name not in self._open_pictures]:
            del self._pictures[name]
            self._open_pictures.add(name)
            await asyncio.wait_for(self._socket.send_bytes(self._source.pictures[name]), SENDING_S)

    async def _send(self, text: bytes) -> None:
        await asyncio.wait_for(self._socket.send_text(text.decode()), SENDING_S)
