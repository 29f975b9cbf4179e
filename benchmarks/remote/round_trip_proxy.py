"""A proxy between a client and a server that counts the round trips."""

from __future__ import annotations

import re
import selectors
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType

from drivers.vrep.wire.codec import decode_message
from drivers.vrep.wire.message_socket import Unpacker
from tests.doubles.coppeliasim.legacy.codec import Code

CHUNK_BYTES = 1 << 18

Words = Callable[[bytes], str]
"""A function that returns the text of a request, given its bytes."""

_CALL = re.compile(rb"(zmqRemoteApi\.\w+?|sim\.\w+?|_\*\w+?\*_)dargs")
"""The name of a function in CBOR, before the key ``args``, a text of four letters."""


def list_calls(request: bytes) -> str:
    """Return the names of the functions that a request of the ZeroMQ remote API calls."""
    return b" ".join(_CALL.findall(request)).decode()


def list_commands(request: bytes) -> str:
    """Return the names of the commands in a message of the legacy remote API."""
    message = Unpacker().feed(request)
    commands = decode_message(message)[1] if message else []
    return ", ".join(Code(each.command).name.lower() for each in commands) or "nothing more"


class RoundTripProxy:
    """A port that forwards to a server, as a context manager. It stores the requests of the clients.

    A request is everything that a client sends until a reply comes. If the client does not wait for each reply, there
    are fewer requests than messages.
    """

    def __init__(self, host: str, port: int, words: Words) -> None:
        self._server, self._words = (host, port), words
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listening.getsockname()[1]
        self.requests: list[str] = []
        self._thread = threading.Thread(target=self._accept, name="counted line", daemon=True)

    def __enter__(self) -> RoundTripProxy:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        with suppress(OSError):
            self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()
        self._thread.join()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._listening.accept()
                threading.Thread(target=self._relay, args=(client,), name="counted client", daemon=True).start()

    def _relay(self, client: socket.socket) -> None:
        request = b""
        with client, socket.create_connection(self._server) as server, selectors.DefaultSelector() as ready:
            for one, other in ((client, server), (server, client)):
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                ready.register(one, selectors.EVENT_READ, other)
            with suppress(OSError):
                while True:
                    for key, _ in ready.select():
                        if not (chunk := key.fileobj.recv(CHUNK_BYTES)):  # type: ignore[union-attr]
                            return
                        if key.fileobj is client:
                            request += chunk
                        elif request:
                            self.requests.append(self._words(request))
                            request = b""
                        key.data.sendall(chunk)
