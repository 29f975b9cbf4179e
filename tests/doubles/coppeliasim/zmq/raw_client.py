"""A ZeroMQ client for tests that sends one message at a time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.zmq.wire import dumps, loads

PATIENCE_MS = 5000
PAUSE_S = 0.01
WAIT = "_*wait*_"
EXECUTED = {"func": "_*executed*_", "args": []}


class RawClient:
    """A client that is identified by a name."""

    def __init__(self, socket: Any, name: str) -> None:
        self._socket, self._name = socket, name

    def exchange(self, message: dict[str, Any]) -> Any:
        """Send a message, and return its reply."""
        return self.exchange_bytes(dumps({**message, "uuid": self._name}))

    def exchange_bytes(self, message: bytes) -> Any:
        self._socket.send(message)
        return loads(self._socket.recv())

    def call(self, function: str, *args: Any, **more: Any) -> Any:
        """Send a call, and return its first reply, which may be a wait message."""
        return self.exchange({"func": function, "args": list(args), **more})

    def finish(self, reply: Any) -> Any:
        """Exchange wait messages until a call ends, and return the last reply."""
        while reply.get("func") == WAIT:
            reply = self.exchange(EXECUTED)
        return reply

    def call_and_wait(self, function: str, *args: Any) -> Any:
        """Send a call, and return the reply that ends it."""
        return self.finish(self.call(function, *args))


def await_time(client: RawClient) -> None:
    """Wait until the simulation's time advances."""
    clock = MonotonicClock()
    while client.call("sim.getSimulationTime")["ret"][0] == 0.0:
        assert clock.now() < PATIENCE_MS / 1000, "time stands still"
        clock.sleep_until(clock.now() + PAUSE_S)


@contextmanager
def connect_clients(port: int, *names: str) -> Iterator[tuple[RawClient, ...]]:
    """Connect clients to a server on this computer."""
    import zmq

    with zmq.Context() as context:
        sockets = [context.socket(zmq.REQ) for _ in names]
        for socket in sockets:
            socket.linger, socket.rcvtimeo = 0, PATIENCE_MS
            socket.connect(f"tcp://127.0.0.1:{port}")
        try:
            yield tuple(RawClient(socket, name) for socket, name in zip(sockets, names, strict=True))
        finally:
            for socket in sockets:
                socket.close()
