"""A client for tests that says one message at a time."""

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


class Talker:
    """One client by a name of its own."""

    def __init__(self, socket: Any, name: str) -> None:
        self._socket, self._name = socket, name

    def say(self, message: dict[str, Any]) -> Any:
        """Return the reply to one message."""
        return self.say_bytes(dumps({**message, "uuid": self._name}))

    def say_bytes(self, message: bytes) -> Any:
        self._socket.send(message)
        return loads(self._socket.recv())

    def call(self, function: str, *args: Any, **more: Any) -> Any:
        """Return the reply to a call; one that waits says so, and is not waited for."""
        return self.say({"func": function, "args": list(args), **more})

    def finish(self, reply: Any) -> Any:
        """Return what a waiting call is answered in the end."""
        while reply.get("func") == WAIT:
            reply = self.say(EXECUTED)
        return reply

    def done(self, function: str, *args: Any) -> Any:
        """Return what a call is answered in the end."""
        return self.finish(self.call(function, *args))


def await_time(talker: Talker) -> None:
    """Wait until the simulation's time goes on."""
    clock = MonotonicClock()
    while talker.call("sim.getSimulationTime")["ret"][0] == 0.0:
        assert clock.now() < PATIENCE_MS / 1000, "time stands still"
        clock.sleep_until(clock.now() + PAUSE_S)


@contextmanager
def talking(port: int, *names: str) -> Iterator[tuple[Talker, ...]]:
    """Connect clients to a server of this machine."""
    import zmq

    with zmq.Context() as context:
        sockets = [context.socket(zmq.REQ) for _ in names]
        for socket in sockets:
            socket.linger, socket.rcvtimeo = 0, PATIENCE_MS
            socket.connect(f"tcp://127.0.0.1:{port}")
        try:
            yield tuple(Talker(socket, name) for socket, name in zip(sockets, names, strict=True))
        finally:
            for socket in sockets:
                socket.close()
