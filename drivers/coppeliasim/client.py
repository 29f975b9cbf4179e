"""CoppeliaSim's own ZeroMQ client, extended by a deadline for each call and by checks of each reply.

During a long call, the server and the client exchange wait messages (``_*wait*_``, ``_*executed*_``). Each of them
restarts the time-out of the socket. So only a deadline limits the whole call.

CoppeliaSim's own client waits without limit. It adds a function ``require`` to ``__main__``, and runs any function of
``__main__`` that a reply names. The client of this module does none of these.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Any
from uuid import uuid4

import zmq
from cbor.cbor import loads  # in Python: the extension in C crashes on deeply nested lists
from coppeliasim_zmqremoteapi_client import RemoteAPIClient

from drivers.coppeliasim.address import Address, RefusedError, build_answer_error, build_error, is_listening
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock

_MISSING = object()
_POLL_S = 0.2
_LINGER_MS = 200
"""The time for which `Client.close` waits until queued calls are sent, in milliseconds."""

_WAIT_MESSAGES = ("_*wait*_", "_*repeat*_")
"""The messages that a server may send during a call, before its reply."""


class Client(RemoteAPIClient):  # type: ignore[misc]  # the library has no types
    """A client of one server. After any other error than RefusedError it is unusable.

    idle_s: the time without a call after which the server drops this client, in seconds.
    """

    def __init__(self, address: Address, idle_s: float) -> None:
        main = sys.modules["__main__"].__dict__
        original = main.get("require", _MISSING)
        try:
            super().__init__(address.host, address.port, verbose=0)
        except zmq.ZMQError as error:
            raise build_error(
                address, "invalid-address", f"{address} is not a valid address: {error}. Correct --host"
            ) from error
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
        self._address, self._function = address, ""
        self._limit_s = self._deadline = 0.0
        self._has_answered = False

    def watch_disconnects(self) -> None:
        """Make each further call raise an error once the server has disconnected.

        Otherwise the library would silently connect again, even to another server at the same address.
        """
        self._disconnects = self.socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        self._poller.register(self._disconnects, zmq.POLLIN)

    def call_within(self, function: str, arguments: Sequence[Any], within_s: float) -> Any:
        """Call a function of the server, and return its result.

        within_s: time limit of the call, in seconds.

        Raises RefusedError if the server answers with an error, and BackendError if it has ended, does not answer in
        time, or sends an invalid reply.
        """
        self._function, self._limit_s, self._deadline = function, within_s, self._clock.now() + within_s
        return self.call(function, list(arguments))

    def queue(self, function: str, arguments: Sequence[Any]) -> None:
        """Send a call without waiting for its answer, although an earlier call may have none. No error is raised.

        A frozen server executes the call once it continues, even if this client is closed. The call has a new client's
        identifier, because the server takes the next message of a client that waits for a step as part of the wait.
        """
        self.uuid, self.sendCnt = str(uuid4()), 0
        with suppress(zmq.ZMQError):  # the server has ended, or the queue is full
            self.socket.setsockopt(zmq.REQ_RELAXED, 1)
            self.socket.setsockopt(zmq.LINGER, _LINGER_MS)
            super()._send({"func": function, "args": list(arguments)})

    def shorten_deadline(self, within_s: float) -> None:
        """Limit the rest of the call in progress to ``within_s`` seconds. Any thread may call this method."""
        self._deadline = min(self._deadline, self._clock.now() + within_s)

    def close(self) -> None:
        """Close the socket. A second call does nothing."""
        if self._disconnects:
            self._disconnects.close(linger=0)
        self.socket.close()
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
            raise self._build_timeout_error() from error

    def _recv(self) -> dict[str, Any]:
        left, ready = self._poll_until_deadline()
        if self.socket not in ready:
            raise self._build_gone_error() if ready else self._build_timeout_error()
        reply = self._decode_reply(self.socket.recv(zmq.NOBLOCK))
        if not left and "func" in reply:  # a server may send wait messages without end
            raise self._build_timeout_error()
        self._has_answered = True
        return reply

    def _decode_reply(self, raw: bytes) -> dict[str, Any]:
        try:
            reply = loads(raw)
        except Exception as error:
            raise self._build_answer_error(f"{len(raw)} bytes that are not CBOR") from error
        if not isinstance(reply, dict):
            raise self._build_answer_error(f"a value of type {type(reply).__name__} instead of a map")
        if "success" in reply:
            raise build_error(
                self._address,
                "server-too-old",
                f"{self._address} uses the first protocol of the ZeroMQ remote API, as CoppeliaSim up to 4.5 does. "
                "Install CoppeliaSim 4.6 or newer, or use --backend vrep",
            )
        if "err" in reply:
            raise RefusedError(
                f"coppeliasim: {self._address} refused {self._function}: {reply['err']}",
                address=str(self._address),
                function=self._function,
            )
        if reply.get("func") in _WAIT_MESSAGES:
            return reply
        if not reply or reply.get("ret") == {}:  # Lua encodes an empty table as a map; _*end*_ has an empty reply
            return {"ret": []}
        if "func" not in reply and isinstance(reply.get("ret"), list):
            return reply
        raise self._build_answer_error(f"a map with {', '.join(sorted(map(str, reply)))[:80]}")

    def _build_answer_error(self, answer: str) -> BackendError:
        return build_answer_error(self._address, self._function, answer)

    def _build_gone_error(self) -> BackendError:
        return build_error(
            self._address,
            "server-gone",
            f"the CoppeliaSim at {self._address} ended during {self._function}. Start CoppeliaSim, and run again",
            function=self._function,
        )

    def _build_timeout_error(self) -> BackendError:
        if not is_listening(self._address):
            return self._build_gone_error()
        advice = "hangs. If it is only slow, raise safety.answer_s in the robot's file"
        return build_error(
            self._address,
            "timeout",
            f"{self._address} has not answered {self._function} for {self._limit_s:.1f} s. Check whether CoppeliaSim "
            f"shows a dialogue or {advice if self._has_answered else 'is busy'}",
            function=self._function,
            limit_s=self._limit_s,
        )

    def _poll_until_deadline(self) -> tuple[float, dict[Any, int]]:
        """Wait for a message until the deadline. Another thread may shorten the deadline.

        Returns the time left in seconds, and the sockets that have a message.
        """
        while True:
            left = max(self._deadline - self._clock.now(), 0.0)
            ready = dict(self._poller.poll(math.ceil(min(left, _POLL_S) * 1000)))  # at least one poll
            if ready or not left:
                return left, ready
