"""A viewer of the page: the messages that wait for it, and its limits."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from typing import Protocol

from starlette.websockets import WebSocket

MAX_MESSAGES = 600
"""A viewer for whom more messages wait is dropped."""

MAX_OPEN_TICKS = 3
"""The number of ticks that a viewer has not acknowledged, before the next ones are skipped."""

SENDING_S = 5.0
"""A viewer who does not read a message for this time, in seconds, is dropped."""


LATE_S = 0.2
"""A command that needed so many seconds more than the fastest one of its viewer is late, and has no effect.

It is `robotcore.runtime.operator_input.LEASE_S`, without an import of the runtime.
"""

MAX_LATE_S = 2.0
"""A viewer whose commands all come late for this time, in seconds, is disconnected. Its clock may have stood still."""

MAX_DRIFT = 1e-3
"""The greatest difference of the rates of two clocks. NTP changes the rate of a clock by up to 5e-4."""


class Delays:
    """Finds the late commands of a viewer, by the viewer's own clock.

    The clock has any zero. So a command counts as in time if its way took hardly longer than the shortest one so far.

    >>> delays = Delays()
    >>> [delays.is_late(sent=0.0, now=50.0), delays.is_late(sent=0.1, now=50.1), delays.is_late(sent=0.2, now=52.0)]
    [False, False, True]
    """

    def __init__(self) -> None:
        self._shortest, self._now = math.inf, 0.0
        self._late_since: float | None = None

    def is_late(self, sent: float, now: float) -> bool:
        """Return whether a command has waited for too long on its way.

        sent: the time at which the viewer sent it, on its own clock in seconds.
        now: the time at which it came, in seconds.

        Raises ValueError if each command for `MAX_LATE_S` was late.
        """
        self._shortest = min(self._shortest + (now - self._now) * MAX_DRIFT, now - sent)
        self._now = now
        if now - sent <= self._shortest + LATE_S:
            self._late_since = None
            return False
        if self._late_since is None:
            self._late_since = now
        if now - self._late_since > MAX_LATE_S:
            raise ValueError("the commands come late")
        return True


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
        self.delays = Delays()
        self._has_tick, self._open_ticks = False, 0
        self._wake, self.is_done = asyncio.Event(), asyncio.Event()
        self.is_ending = False
        """Whether the viewer leaves because the run has ended."""
        self.is_dropped = False

    def add_message(self, text: bytes) -> None:
        """Send a message after those that wait already, or drop the viewer if too many wait."""
        if len(self._messages) < MAX_MESSAGES:
            self._messages.append(text)
        else:
            self.is_dropped = True
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
        while self._messages and not self.is_dropped:
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
