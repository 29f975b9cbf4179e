"""Services of the legacy remote API. Each service has a listening socket, and serves one client at a time.

The operating system accepts a second client, but the service answers it only after the first client has left. The real
server does the same, and disconnects the second client in the end.
"""

from __future__ import annotations

import socket
import threading
from contextlib import ExitStack, suppress
from functools import partial

from tests.doubles.coppeliasim.legacy.client import Client
from tests.doubles.coppeliasim.legacy.codec import ProtocolError, encode_packets, read_message
from tests.doubles.coppeliasim.legacy.faults import Fault, Hang, ServerDiedError
from tests.doubles.coppeliasim.scene import Simulator, State
from tests.doubles.coppeliasim.scene.pacing import Pacer

HOST = "127.0.0.1"


class Service:
    """Serves a simulator on a port until `close`. For ``port`` 0, the operating system chooses a free port."""

    def __init__(self, simulator: Simulator, port: int = 0) -> None:
        self._simulator = simulator
        self._listening = socket.create_server((HOST, port))
        self.port: int = self._listening.getsockname()[1]
        self._line: socket.socket | None = None
        self._is_over = False
        self._fault: Fault | None = None
        self._thread = threading.Thread(target=self._serve, name=f"legacy service on {self.port}", daemon=True)
        self._thread.start()

    def fail(self, fault: Fault | None) -> None:
        """Apply a fault to each further reply. None ends the fault."""
        self._release()
        self._fault = fault

    def disconnect(self) -> None:
        """Close the client's connection, as a killed server does."""
        if line := self._line:
            with suppress(OSError):
                line.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Close the connection and the port."""
        self._is_over = True
        self._stop_listening()
        self._release()
        self.disconnect()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _stop_listening(self) -> None:
        with suppress(OSError):
            self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()

    def _serve(self) -> None:
        with suppress(OSError):
            while not self._is_over:
                self._line, _ = self._listening.accept()
                with self._line as line:
                    self._serve_client(line)

    def _serve_client(self, line: socket.socket) -> None:
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with self._simulator.lock:
            client = Client(self._simulator)
        try:
            with suppress(OSError, EOFError, ServerDiedError, ProtocolError):
                while not (client.is_leaving or self._is_over):
                    self._answer(line, client)
        finally:
            with self._simulator.lock:
                client.leave()

    def _answer(self, line: socket.socket, client: Client) -> None:
        message = read_message(partial(_receive, line))
        with self._simulator.lock:
            answer = client.receive(message)
        if self._fault is None:
            line.sendall(encode_packets(answer))
        else:
            self._fault.send(line, encode_packets(answer))
        with self._simulator.lock:
            self._turn(client)

    def _turn(self, client: Client) -> None:
        client.turn()

    def _release(self) -> None:
        if isinstance(self._fault, Hang):
            self._fault.release()


def _receive(line: socket.socket, size: int) -> bytes:
    """Receive ``size`` bytes. Raises EOFError if the connection ends before."""
    pieces, left = [], size
    while left:
        if not (piece := line.recv(left)):
            raise EOFError
        pieces.append(piece)
        left -= len(piece)
    return b"".join(pieces)


GRACE_S = 0.2
"""The time after a stop during which the service still answers messages, in seconds."""


class TemporaryService(Service):
    """A service that ends with the present simulation. If none runs, it ends with the next one."""

    def __init__(self, simulator: Simulator, port: int = 0) -> None:
        super().__init__(simulator, port)
        self._watcher = threading.Thread(target=self._end_with_the_run, name=f"end of {self.port}", daemon=True)
        self._watcher.start()

    def close(self) -> None:
        super().close()
        with self._simulator.lock:
            self._simulator.changed.notify_all()
        if self._watcher is not threading.current_thread():
            self._watcher.join()

    def _end_with_the_run(self) -> None:
        with self._simulator.lock:
            self._simulator.changed.wait_for(lambda: self._is_over or self._simulator.state is not State.STOPPED)
            self._simulator.changed.wait_for(lambda: self._is_over or self._simulator.state is State.STOPPED)
        self._is_over = True
        self._stop_listening()
        self._thread.join(GRACE_S)
        self.close()


class LegacyServer:
    """Serves a simulator over the legacy remote API, and advances its time; a context manager.

    port: the port; 0 takes a free one.

    The first service is permanent, as port 19997 of an installation.
    """

    def __init__(self, simulator: Simulator, port: int = 0) -> None:
        self._simulator, self._asked_port = simulator, port
        self._open = ExitStack()

    def __enter__(self) -> LegacyServer:
        self.service = Service(self._simulator, self._asked_port)
        self._open.callback(self._close_service)
        self._open.enter_context(Pacer(self._simulator))
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    @property
    def port(self) -> int:
        """The port of the permanent service."""
        return self.service.port

    def close(self) -> None:
        """End all services."""
        self._open.close()

    def restart(self) -> None:
        """Restart on the same port; the client is disconnected."""
        self.service.close()
        self.service = Service(self._simulator, self.port)

    def _close_service(self) -> None:
        self.service.close()

    def start_temporary(self, port: int = 0) -> TemporaryService:
        """Start a service during a simulation, as a script of its scene does."""
        service = TemporaryService(self._simulator, port)
        self._open.callback(service.close)
        return service
