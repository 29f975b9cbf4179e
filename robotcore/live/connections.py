"""The connections of the page's server, with limits on their number, their silence and their memory."""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

MAX_CONNECTIONS = 64
"""A connection beyond this number is closed at once."""

REQUEST_S = 10.0
"""A new connection without a whole request within this time, in seconds, is closed."""


class LimitedHttp(H11Protocol):
    """A connection that must send a request soon, and that the server refuses if it has too many."""

    _timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        if len(self.connections) > MAX_CONNECTIONS:
            transport.abort()
            return
        self._timer = self.loop.call_later(REQUEST_S, self._end_silence)

    def connection_lost(self, exc: Exception | None) -> None:
        if self._timer:
            self._timer.cancel()
        super().connection_lost(exc)

    def _end_silence(self) -> None:
        if self.cycle is None and self.transport.get_protocol() is self:
            self.transport.abort()


class LimitedWebSocket(WebSocketsSansIOProtocol):
    """A WebSocket from which the server does not read while the client does not read.

    Otherwise the answers to a client's pings would need more and more memory.
    """

    def pause_writing(self) -> None:
        super().pause_writing()
        self.transport.pause_reading()

    def resume_writing(self) -> None:
        super().resume_writing()
        if not self.read_paused:
            self.transport.resume_reading()
