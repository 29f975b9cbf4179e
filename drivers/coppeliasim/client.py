"""The maker's client, which would wait for ever, with a deadline for each call and nothing taken on trust.

A call that waits in the simulator is a conversation (``_*wait*_``, ``_*executed*_``), so no time-out of a socket ends
it: the deadline is the whole call's. The client also puts ``require`` into ``__main__``, runs any function of
``__main__`` that a reply names, and sends whatever it is given: none of it happens here.
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
_LOOK_S = 0.2
_CONVERSATION = ("_*wait*_", "_*repeat*_")
"""What a server may ask of a client that registers no callbacks."""


class CallTimeout(Exception):  # noqa: N818  one of four ends of a call, told apart by the connection
    """The deadline of a call has passed."""


class Disconnected(Exception):  # noqa: N818
    """The server has hung up."""


class CallRefused(Exception):  # noqa: N818
    """The server's own error, in its words."""


class ProtocolViolation(Exception):  # noqa: N818
    """What came back is no reply of this protocol; says what it is instead."""


class FirstProtocolReply(ProtocolViolation):
    """What came back is a reply of the remote API's first protocol."""


class Client(RemoteAPIClient):  # type: ignore[misc]  # the library has no types
    """One conversation with one server. ``idle_s`` of silence, and the server forgets it."""

    def __init__(self, host: str, port: int, idle_s: float) -> None:
        main = sys.modules["__main__"].__dict__
        kept = main.get("require", _MISSING)
        try:
            super().__init__(host, port, verbose=0)
        finally:
            if kept is _MISSING:
                main.pop("require", None)
            else:
                main["require"] = kept
        self.timeout = idle_s
        for option in (zmq.LINGER, zmq.SNDTIMEO):
            self.socket.setsockopt(option, 0)
        self._awaited = zmq.Poller()
        self._awaited.register(self.socket, zmq.POLLIN)
        self._hang_ups: zmq.Socket[bytes] | None = None
        self._clock = MonotonicClock()
        self._deadline = 0.0

    def watch_disconnects(self) -> None:
        """Wait for nobody who hangs up from now on: the library would connect again, in silence, to whoever comes."""
        self._hang_ups = self.socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        self._awaited.register(self._hang_ups, zmq.POLLIN)

    def ask(self, function: str, arguments: Sequence[Any], within_s: float) -> Any:
        """Call a function of the server.

        Raises CallTimeout, Disconnected, CallRefused or ProtocolViolation. The first two end the client.
        """
        self._deadline = self._clock.now() + within_s
        return self.call(function, [wire(argument) for argument in arguments])

    def shorten_deadline(self, within_s: float) -> None:
        """Let the call that is under way take no longer than this from now on; any thread may say so."""
        self._deadline = min(self._deadline, self._clock.now() + within_s)

    def close(self) -> None:
        """Let the socket go, with whatever is still to be sent. May be called again."""
        for each in (self._hang_ups, self.socket):
            if each:
                each.close(linger=0)
        self.context.term()

    def __del__(self) -> None:
        """Let go, where nobody has: the library would wait for ever for what is still to be sent."""
        with suppress(AttributeError):  # it was never connected
            self.close()

    def _send(self, request: dict[str, Any]) -> None:
        try:
            super()._send(request)
        except zmq.ZMQError as full:
            raise CallTimeout from full

    def _recv(self) -> dict[str, Any]:
        left, ready = self._awaited_within()
        if self.socket not in ready:
            raise Disconnected if ready else CallTimeout
        reply = _reply_in(self.socket.recv(zmq.NOBLOCK))
        if not left and "func" in reply:  # a server that lets wait answers, and answers, and answers
            raise CallTimeout
        return reply

    def _awaited_within(self) -> tuple[float, dict[Any, int]]:
        """Wait until the deadline, which may be drawn nearer meanwhile; return what was left of it, and what came."""
        while True:
            left = max(self._deadline - self._clock.now(), 0.0)
            ready = dict(self._awaited.poll(math.ceil(min(left, _LOOK_S) * 1000)))  # once at least: we may be late
            if ready or not left:
                return left, ready


def wire(value: Any) -> Any:
    """Return a value as the wire takes it: Python's own numbers, lists and bytes, whatever NumPy made of them."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (bytearray, memoryview)):
        return bytes(value)
    if isinstance(value, Mapping):
        return {str(key): wire(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [wire(part) for part in value]
    return value


def _reply_in(raw: bytes) -> dict[str, Any]:
    """Return the reply in a message; raises ProtocolViolation if there is none, CallRefused if it tells an error."""
    try:
        reply = cbor.loads(raw)
    except Exception as error:
        raise ProtocolViolation(f"{len(raw)} bytes that are no CBOR") from error
    if not isinstance(reply, dict):
        raise ProtocolViolation(f"no map but {type(reply).__name__}")
    if "success" in reply:
        raise FirstProtocolReply
    if "err" in reply:
        raise CallRefused(str(reply["err"]))
    if reply.get("func") in _CONVERSATION:
        return reply
    if not reply or reply.get("ret") == {}:  # an empty table of Lua's is a map; who leaves is told nothing
        return {"ret": []}
    if "func" not in reply and isinstance(reply.get("ret"), list):
        return reply
    raise ProtocolViolation(f"a map with {', '.join(sorted(map(str, reply)))[:80]}")
