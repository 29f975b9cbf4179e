"""The connections of the page's server, with limits on their number, their time, their rate and their memory."""

from __future__ import annotations

import asyncio
import socket
from collections import Counter
from collections.abc import Iterable
from typing import Any

from starlette.websockets import WebSocket
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame, Opcode

MAX_CONNECTIONS = 128
"""Beyond this number, a new connection ends the oldest one that is not a viewer's."""

MAX_ACCEPTED = 8
"""The number of connections that the server accepts before it reads from the others again.

It is far below `MAX_CONNECTIONS`, so that many new connections at once do not end one with a request on its way.
"""

REQUEST_S = 10.0
"""A connection with an unfinished request or answer after this time, in seconds, is closed."""

CLOSING_S = 1.0
"""The longest wait, in seconds, until a client has read the last bytes of a WebSocket."""

MAX_RATE_HZ = 300.0
"""A WebSocket with more frames in a second is closed."""

MAX_REQUEST_BYTES = 16_384
"""The greatest size of a request."""

CHUNK_BYTES = 1024
"""The server parses so many bytes, and checks its limits, before it parses the next ones."""


WIRE = "robotcore.wire"
"""The key of a WebSocket's scope with its `LimitedWebSocket`."""


class Listener(socket.socket):
    """A socket whose queue of new connections is longer than `MAX_ACCEPTED`."""

    def listen(self, _accepted: int = 0, /) -> None:
        super().listen(MAX_CONNECTIONS)


class LimitedHttp(H11Protocol):
    """A connection for one request, which must end soon. It may replace an older connection."""

    is_viewer = False
    _timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        self.started = self.loop.time()
        make_room(self.connections)
        self._timer = self.loop.call_later(REQUEST_S, self._end)

    def connection_lost(self, exc: Exception | None) -> None:
        if self._timer:
            self._timer.cancel()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        for start in range(0, len(data), CHUNK_BYTES):
            if self.cycle is None and self._is_open():  # no request of the page has a body
                super().data_received(data[start : start + CHUNK_BYTES])

    def _is_open(self) -> bool:
        """Return whether the connection is neither closed nor a WebSocket now."""
        return not self.transport.is_closing() and self.transport.get_protocol() is self

    def _end(self) -> None:
        if self.transport.get_protocol() is self:
            self.transport.abort()


class LimitedWebSocket(WebSocketsSansIOProtocol):
    """A WebSocket that counts each frame, also pings. The first frame must be a text: the token.

    It may be replaced like a `LimitedHttp` until the application calls `mark_viewer`.
    """

    is_viewer = False
    """Whether the server has accepted the client's token."""
    _has_text = False

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        self.started = self.loop.time()
        self._rate = RateLimit(MAX_RATE_HZ, self.started)

    def data_received(self, data: bytes) -> None:
        for start in range(0, len(data), CHUNK_BYTES):
            if not self.transport.is_closing():
                super().data_received(data[start : start + CHUNK_BYTES])

    def handle_events(self) -> None:
        for event in self.conn.events:
            if isinstance(event, Frame):
                self._has_text |= event.opcode is Opcode.TEXT
                if not (self._has_text and self._rate.take(self.loop.time())):
                    self.transport.abort()
                    return
        super().handle_events()

    async def run_asgi(self) -> None:
        self.scope[WIRE] = self  # type: ignore[literal-required]
        await super().run_asgi()

    def keepalive_timeout(self) -> None:
        self.transport.abort()  # a close would wait until the client reads

    def on_task_complete(self, task: asyncio.Task[None]) -> None:
        super().on_task_complete(task)
        self.loop.call_later(CLOSING_S, self.transport.abort)


def mark_viewer(socket: WebSocket) -> None:
    """Keep a WebSocket whose client has sent the right token, if there are too many connections."""
    socket.scope[WIRE].is_viewer = True


class RateLimit:
    """Counts events, and refuses those above a rate. A pause allows a burst of one second.

    >>> limit = RateLimit(2.0, now=0.0)
    >>> [limit.take(0.0), limit.take(0.0), limit.take(0.0), limit.take(0.6)]
    [True, True, False, True]
    """

    def __init__(self, rate_hz: float, now: float) -> None:
        self._rate_hz, self._left, self._time = rate_hz, rate_hz, now

    def take(self, now: float) -> bool:
        """Count an event at a time in seconds. Return whether it is within the rate."""
        self._left = min(self._rate_hz, self._left + (now - self._time) * self._rate_hz)
        self._time = now
        if self._left < 1:
            return False
        self._left -= 1
        return True


def make_room(connections: Iterable[Any]) -> None:
    """Close a connection that is not a viewer's if there are too many: the oldest one of the address with the most.

    So a client cannot take all connections away from a press of the e-stop, which needs its own for an instant only.
    """
    opened = [each for each in connections if not each.transport.is_closing()]
    if len(opened) <= MAX_CONNECTIONS:
        return
    others = [each for each in opened if not each.is_viewer]
    counts = Counter(each.client and each.client[0] for each in others)
    max(others, key=lambda each: (counts[each.client and each.client[0]], -each.started)).transport.abort()
