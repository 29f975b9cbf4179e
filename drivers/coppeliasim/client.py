"""CoppeliaSim's own ZeroMQ client, extended by a deadline for each call and by checks of each reply.

During a long call, the server and the client exchange wait messages (``_*wait*_``, ``_*executed*_``). Each of them
restarts the time-out of the socket. So only a deadline limits the whole call.

CoppeliaSim's own client waits without limit. It adds a function ``require`` to ``__main__``, and runs any function of
``__main__`` that a reply names. The client of this module does none of these.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import zmq
from coppeliasim_zmqremoteapi_client import RemoteAPIClient, cbor

from robotcore.hal.wall_clock import MonotonicClock

_MISSING = object()
_POLL_S = 0.2
_WAIT_MESSAGES = ("_*wait*_", "_*repeat*_")
"""The messages that a server may send during a call, before its reply."""


class CallTimeout(Exception):  # noqa: N818  an outcome that SimulatorConnection converts to an error
    """The deadline of a call has passed."""


class Disconnected(Exception):  # noqa: N818
    """The server closed the connection."""


class CallRefused(Exception):  # noqa: N818
    """The server answered the call with an error. The message comes from the server."""


class ProtocolViolation(Exception):  # noqa: N818
    """The reply does not follow the protocol. The message describes the reply."""


class FirstProtocolReply(ProtocolViolation):
    """The reply follows the first protocol of the remote API, which CoppeliaSim up to 4.5 uses."""


class Client(RemoteAPIClient):  # type: ignore[misc]  # the library has no types
    """A client of one server.

    idle_s: the time without a call after which the server drops this client, in seconds.
    """

    def __init__(self, host: str, port: int, idle_s: float) -> None:
        main = sys.modules["__main__"].__dict__
        original = main.get("require", _MISSING)
        try:
            super().__init__(host, port, verbose=0)
        finally:
            if original is _MISSING:
                main.pop("require", None)
            else:
                main["require"] = original
        self.timeout = idle_s
        for option in (zmq.LINGER, zmq.SNDTIMEO):
            self.socket.setsockopt(option, 0)
        self._poller = zmq.Poller()
        self._poller.register(self.socket, zmq.POLLIN)
        self._disconnects: zmq.Socket[bytes] | None = None
        self._clock = MonotonicClock()
        self._deadline = 0.0

    def watch_disconnects(self) -> None:
        """Make each further call raise Disconnected once the server has disconnected.

        Otherwise the library would silently connect again, even to another server at the same address.
        """
        self._disconnects = self.socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        self._poller.register(self._disconnects, zmq.POLLIN)

    def call_within(self, function: str, arguments: Sequence[Any], within_s: float) -> Any:
        """Call a function of the server, and return its result.

        within_s: time limit of the call, in seconds.

        Raises CallTimeout, Disconnected, CallRefused or ProtocolViolation. After CallTimeout or
        Disconnected, the client is unusable.
        """
        self._deadline = self._clock.now() + within_s
        return self.call(function, [to_wire(argument) for argument in arguments])

    def shorten_deadline(self, within_s: float) -> None:
        """Limit the rest of the call in progress to ``within_s`` seconds. Any thread may call this method."""
        self._deadline = min(self._deadline, self._clock.now() + within_s)

    def close(self) -> None:
        """Close the socket, and drop the messages that are not sent yet. A second call does nothing."""
        for each in (self._disconnects, self.socket):
            if each:
                each.close(linger=0)
        self.context.term()

    def __del__(self) -> None:
        """Close the socket if the caller has not closed it.

        Otherwise the library would wait without limit until all messages are sent.
        """
        with suppress(AttributeError):  # the constructor failed
            self.close()

    def _send(self, request: dict[str, Any]) -> None:
        try:
            super()._send(request)
        except zmq.ZMQError as error:  # the queue is full
            raise CallTimeout from error

    def _recv(self) -> dict[str, Any]:
        left, ready = self._poll_until_deadline()
        if self.socket not in ready:
            raise Disconnected if ready else CallTimeout
        reply = _decode_reply(self.socket.recv(zmq.NOBLOCK))
        if not left and "func" in reply:  # a server may send wait messages without end
            raise CallTimeout
        return reply

    def _poll_until_deadline(self) -> tuple[float, dict[Any, int]]:
        """Wait for a message until the deadline. Another thread may shorten the deadline.

        Returns the time left in seconds, and the sockets that have a message.
        """
        while True:
            left = max(self._deadline - self._clock.now(), 0.0)
            ready = dict(self._poller.poll(math.ceil(min(left, _POLL_S) * 1000)))  # at least one poll
            if ready or not left:
                return left, ready


def to_wire(value: Any) -> Any:
    """Convert a value to types that CBOR can encode. NumPy's types, mappings and buffers need this.

    >>> to_wire({"size": np.array([1.5, 2.0]), "count": np.int64(3)})
    {'size': [1.5, 2.0], 'count': 3}
    """
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (bytearray, memoryview)):
        return bytes(value)
    if isinstance(value, Mapping):
        return {str(key): to_wire(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_wire(part) for part in value]
    return value


def _decode_reply(raw: bytes) -> dict[str, Any]:
    try:
        reply = cbor.loads(raw)
    except Exception as error:
        raise ProtocolViolation(f"{len(raw)} bytes that are not CBOR") from error
    if not isinstance(reply, dict):
        raise ProtocolViolation(f"a value of type {type(reply).__name__} instead of a map")
    if "success" in reply:
        raise FirstProtocolReply
    if "err" in reply:
        raise CallRefused(str(reply["err"]))
    if reply.get("func") in _WAIT_MESSAGES:
        return reply
    if not reply or reply.get("ret") == {}:  # Lua encodes an empty table as a map; _*end*_ has an empty reply
        return {"ret": []}
    if "func" not in reply and isinstance(reply.get("ret"), list):
        return reply
    raise ProtocolViolation(f"a map with {', '.join(sorted(map(str, reply)))[:80]}")
