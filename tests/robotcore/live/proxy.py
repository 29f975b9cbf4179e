"""A network between a browser and a server, which a test can cut."""

from __future__ import annotations

import socket
from contextlib import suppress

from robotcore.threads import start_thread


class Proxy:
    """Passes each connection to a port of this machine.

    port: the port of the server.
    """

    def __init__(self, port: int) -> None:
        self._target, self._is_cut, self._ends = port, False, list[socket.socket]()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        start_thread(self._accept, "proxy")

    def cut(self) -> None:
        """Close each connection, also the next ones."""
        self._is_cut = True
        for end in self._ends:
            shut(end)

    def mend(self) -> None:
        """Pass the next connections again."""
        self._is_cut = False

    def close(self) -> None:
        self.cut()
        shut(self._listener)

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                if self._is_cut:
                    shut(client)
                    continue
                server = socket.create_connection(("127.0.0.1", self._target))
                self._ends += [client, server]
                start_thread(lambda a=client, b=server: self._pass_on(a, b), "proxy")  # type: ignore[misc]
                start_thread(lambda a=server, b=client: self._pass_on(a, b), "proxy")  # type: ignore[misc]

    def _pass_on(self, source: socket.socket, target: socket.socket) -> None:
        with suppress(OSError):
            while data := source.recv(65536):
                target.sendall(data)
        shut(source)
        shut(target)


def shut(end: socket.socket) -> None:
    with suppress(OSError):
        end.shutdown(socket.SHUT_RDWR)
    end.close()
