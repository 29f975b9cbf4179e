"""A client of the live page's socket, without a browser."""

from __future__ import annotations

import json
from contextlib import ExitStack
from typing import Any
from urllib.parse import urlsplit

from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from robotcore.hal.wall_clock import MonotonicClock
from tests.robotcore.live.live_run import LiveRun

TIMEOUT_S = 10.0
CLOSING_S = 0.5


class Client:
    """A viewer of a run. It acknowledges what it gets, and sends the time with each command that moves something.

    origin: the origin of the page that opens the socket; empty for the run's own page.
    token: the token; None for that of the link.
    link: the link; empty for that of the run.
    """

    def __init__(self, run: LiveRun, origin: str = "", token: str | None = None, link: str = "") -> None:
        parts = urlsplit(link or run.view.link)
        self.origin = f"http://{parts.netloc}"
        url, self._stack = f"ws://{parts.netloc}/live", ExitStack()
        connection = connect(
            url, origin=Origin(origin or self.origin), max_size=None, open_timeout=TIMEOUT_S, close_timeout=CLOSING_S
        )
        self._clock = MonotonicClock()
        self.socket: ClientConnection = self._stack.enter_context(connection)
        self.send(type="hello", token=parts.fragment.removeprefix("token=") if token is None else token)

    def send(self, **message: Any) -> None:
        if message["type"] in {"drive", "actuate"}:
            message = {"sent": 1000 * self._clock.now(), **message}
        self.socket.send(json.dumps(message))

    def receive(self, kind: str) -> dict[str, Any]:
        """Return the next message of a type. Messages of other types are skipped."""
        while True:
            data = self.socket.recv(TIMEOUT_S)
            if isinstance(data, bytes):
                self.send(type="ack", picture=data[1 : 1 + data[0]].decode())
                continue
            message: dict[str, Any] = json.loads(data)
            if message["type"] == "tick":
                self.send(type="ack", tick=message["tick"])
            if message["type"] == kind:
                return message

    def receive_picture(self, name: str) -> bytes:
        """Return the next picture of a name."""
        while True:
            data = self.socket.recv(TIMEOUT_S)
            if isinstance(data, bytes) and data[1 : 1 + data[0]].decode() == name:
                return data[1 + data[0] :]

    def close(self) -> None:
        self._stack.close()
