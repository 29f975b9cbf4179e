"""One port of the legacy remote API: a listening socket, and one client at a time.

Who connects meanwhile is accepted by the system and not answered until the client before has left; the maker's server
leaves its second client alone in the same way, and hangs up on it in the end.
"""

from __future__ import annotations

import socket
import threading
from contextlib import ExitStack, suppress
from functools import partial
from types import TracebackType

from tests.doubles.coppeliasim.legacy.client import Client
from tests.doubles.coppeliasim.legacy.codec import PACKET_SIZE, ProtocolError, packed_up, read_message
from tests.doubles.coppeliasim.legacy.faults import Fault, Hang, ServerDiedError
from tests.doubles.coppeliasim.scene.pacing import Pacer
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State

HOST = "127.0.0.1"


class Service:
    """Serves a simulator on a port, from its making until it is closed; ``port`` 0 takes a free one."""

    def __init__(self, simulator: Simulator, port: int = 0, packet_size: int = PACKET_SIZE) -> None:
        self._simulator, self._packet_size = simulator, packet_size
        self._listening = socket.create_server((HOST, port))
        self.port: int = self._listening.getsockname()[1]
        self._line: socket.socket | None = None
        self._is_over = False
        self._fault: Fault | None = None
        self._answers_before_fault = 0
        self._thread = threading.Thread(target=self._serve, name=f"legacy service on {self.port}", daemon=True)
        self._thread.start()

    def fail(self, fault: Fault | None, after: int = 0) -> None:
        """Treat every answer so from now on, or after so many that are sent as they should be; None: be well again."""
        self._release()
        self._fault, self._answers_before_fault = fault, after

    def hang_up(self) -> None:
        """Tear the client's connection off, as a server does that is killed."""
        if line := self._line:
            with suppress(OSError):
                line.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Hang up and listen no longer."""
        self._is_over = True
        self._stop_listening()
        self._release()
        self.hang_up()
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
                    self._attend(line)

    def _attend(self, line: socket.socket) -> None:
        """Answer a client until it leaves, is cut off, or says what is no message."""
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
        message = read_message(partial(_exactly, line))
        with self._simulator.lock:
            answer = client.receive(message)
        self._send(line, packed_up(answer, self._packet_size))
        with self._simulator.lock:
            self._turn(client)

    def _turn(self, client: Client) -> None:
        """Take the main loop's turn that follows a message."""
        client.turn()

    def _send(self, line: socket.socket, answer: bytes) -> None:
        if self._fault is None or self._answers_before_fault > 0:
            self._answers_before_fault -= 1
            line.sendall(answer)
        else:
            self._fault.send(line, answer)

    def _release(self) -> None:
        if isinstance(self._fault, Hang):
            self._fault.release()


def _exactly(line: socket.socket, size: int) -> bytes:
    """Return the next bytes of a connection; EOFError where it ends before."""
    pieces, left = [], size
    while left:
        if not (piece := line.recv(left)):
            raise EOFError
        pieces.append(piece)
        left -= len(piece)
    return b"".join(pieces)


LAST_WORD_S = 0.2
"""Who has a question on the way when the simulation stops is answered, if it comes within this time."""


class TemporaryService(Service):
    """A service that ends with the run it was started in, or with the next one if none is under way."""

    def __init__(self, simulator: Simulator, port: int = 0, packet_size: int = PACKET_SIZE) -> None:
        super().__init__(simulator, port, packet_size)
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
        self._thread.join(LAST_WORD_S)
        self.close()


class LegacyServer:
    """Serves a simulator over the legacy remote API; a context manager. ``port`` 0 takes a free one.

    The service it begins with is continuous, like 19997 of an installation. Time passes by itself while nobody steps;
    where somebody else sees to that, ``paces`` is False.

    >>> with LegacyServer(Simulator()) as server:
    ...     server.port > 0
    True
    """

    def __init__(self, simulator: Simulator, port: int = 0, *, paces: bool = True) -> None:
        self._simulator, self._asked_port = simulator, port
        self._paces = paces
        self._open = ExitStack()

    def __enter__(self) -> LegacyServer:
        if self._paces:
            self._open.enter_context(Pacer(self._simulator))
        self.service = Service(self._simulator, self._asked_port)
        self._open.callback(self._close_service)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    @property
    def port(self) -> int:
        """The port of the continuous service."""
        return self.service.port

    def close(self) -> None:
        """End every service."""
        self._open.close()

    def restart(self) -> None:
        """Be a new process on the same port: the client of the old one is cut off."""
        self.service.close()
        self.service = Service(self._simulator, self.port)

    def _close_service(self) -> None:
        self.service.close()

    def start_temporary(self, port: int = 0) -> TemporaryService:
        """Start a service in the simulation that runs, as a script of its scene does."""
        service = TemporaryService(self._simulator, port)
        self._open.callback(service.close)
        return service
