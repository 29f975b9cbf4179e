"""Exchange messages with a server in a separate thread, which sends queued commands and stores the newest answers."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing

from drivers.vrep.wire.codec import NOTHING_DONE, Header, Piece
from drivers.vrep.wire.errors import NoServerError, RemoteApiError, ServerLostError
from drivers.vrep.wire.message_socket import RETRY_S, MessageSocket
from drivers.vrep.wire.requests import DISCONTINUE, Identity, Request
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.threads import start_thread

_SHORTEST_PERIOD_S, _LONGEST_PERIOD_S = 0.0005, 0.004
"""The first and the longest period of messages while a call waits for an answer, in seconds."""


class MessagePump:
    """Exchanges messages with a server in its own thread, until `close`. Any thread may call the methods.

    connect: connects to the server.
    period_s: the period of messages, in seconds. It is shorter while a call waits for an answer.
    connect_timeout_s: the time during which to try again to connect, in seconds.
    reconnects: whether to connect again after the connection was lost. If False, the attribute ``failure`` is set to
        the error.

    If the connection is lost, the queued commands and the stored answers are dropped.
    """

    def __init__(
        self, connect: Callable[[], MessageSocket], period_s: float, connect_timeout_s: float, *, reconnects: bool
    ) -> None:
        self._connect, self._period_s, self._connect_timeout_s = connect, period_s, connect_timeout_s
        self._reconnects = reconnects
        self._changed = threading.Condition()
        self._outgoing: dict[Identity, bytes] = {}
        self._newest: dict[Identity, Piece] = {}
        self._number = 0
        self._last_posted = -1
        self._waiters = 0
        self._is_urgent = self._is_paused = self._is_closing = self._is_answered = False
        self._socket: MessageSocket | None = None
        self._clock = MonotonicClock()
        self._last_progress_s = 0.0
        self._waiting_period_s = _SHORTEST_PERIOD_S
        self.connections = 0
        """The number of connections so far on which the server has replied."""
        self.server: Header | None = None
        """The header of the newest reply after which the server had executed a message; None without a reply."""
        self.time_ms = 0
        """The simulation's time in the newest answer, in ms."""
        self.failure: RemoteApiError | None = None
        self._thread = start_thread(self._run, "remote api")

    @property
    def is_connected(self) -> bool:
        """Whether the server has replied on the present connection."""
        return self._is_answered

    @property
    def number(self) -> int:
        """The number of the next message."""
        return self._number

    @property
    def silence_s(self) -> float:
        """The time since the server has executed a command or streamed a value, in seconds."""
        return self._clock.now() - self._last_progress_s

    def post(self, request: Request[object], mode: int, delay: int = 0) -> int:
        """Queue a command for the next message, and return the number of this message.

        mode, delay: see `encode_command`.

        The command replaces a queued command with the same number and key.
        """
        with self._changed:
            self._outgoing[request.identity] = request.encode(mode, delay)
            self._last_posted = self._number
            return self._number

    def wait(self, number: int, timeout_s: float) -> bool:
        """Wait until the server has executed the commands of a message. Return False after the time-out.

        number: the number of the message.
        """
        with self._changed:
            self._waiters += 1
            self._is_urgent, self._waiting_period_s = True, _SHORTEST_PERIOD_S
            self._changed.notify_all()
            try:
                self._changed.wait_for(lambda: self._has_done(number) or self._is_over, timeout_s)
            finally:  # a signal may interrupt the wait
                self._waiters -= 1
            return self._has_done(number)

    def wait_connected(self, timeout_s: float) -> bool:
        """Wait until the server has replied on a connection. Return False after the time-out."""
        with self._changed:
            self._changed.wait_for(lambda: self.is_connected or self._is_over, timeout_s)
            return self.is_connected

    def newest(self, request: Request[object]) -> Piece | None:
        """Return the newest stored answer to a request; None if there is none."""
        with self._changed:
            return self._newest.get(request.identity)

    def take(self, request: Request[object]) -> Piece | None:
        """Remove the newest stored answer to a request, and return it; None if there is none."""
        with self._changed:
            return self._newest.pop(request.identity, None)

    def set_paused(self, *, is_paused: bool) -> None:
        """Pause or resume the exchange of messages. After a pause, one message sends all queued commands."""
        with self._changed:
            self._is_paused = is_paused
            self._changed.notify_all()

    def close(self, timeout_s: float, *, finish: bool = True) -> None:
        """Disconnect, and end the thread.

        timeout_s: the time limit of each wait, in seconds.
        finish: whether to wait first until the server has executed all posted commands. If False, they may be lost.
        """
        self.set_paused(is_paused=False)
        if finish and self._last_posted >= 0:
            self.wait(self._last_posted, timeout_s)
        with self._changed:
            self._is_closing = True
            self._changed.notify_all()
        self._thread.join(timeout_s)
        if socket := self._socket:
            socket.close()
        self._thread.join(timeout_s)

    @property
    def _is_over(self) -> bool:
        return not self._thread.is_alive() or self.failure is not None

    def _has_done(self, number: int) -> bool:
        return self.server is not None and self.server.message >= number

    def _run(self) -> None:
        while not self._is_closing:
            try:
                with closing(self._connect()) as socket:
                    self._exchange_messages(socket)
            except RemoteApiError as failure:
                if not (self._reconnects or self._is_retryable(failure)):
                    self._drop_connection(failure)
                    return
                self._drop_connection()
                with self._changed:
                    self._changed.wait_for(lambda: self._is_closing, RETRY_S)
            self._socket = None

    def _is_retryable(self, failure: RemoteApiError) -> bool:
        """Return whether to try again to connect after this error.

        For a short time after another program has disconnected, a server refuses or closes connections.
        """
        is_transient = isinstance(failure, (NoServerError, ServerLostError))
        return is_transient and not self.connections and self._clock.now() + RETRY_S <= self._connect_timeout_s

    def _exchange_messages(self, socket: MessageSocket) -> None:
        with self._changed:
            self._socket = socket
            self._is_urgent = True
        while self._wait_for_turn():
            number, outgoing = self._take_message()
            self._receive(*socket.exchange(number, outgoing))

    def _wait_for_turn(self) -> bool:
        with self._changed:
            pause_s = min(self._period_s, self._waiting_period_s) if self._waiters else self._period_s
            self._changed.wait_for(lambda: self._is_closing or self._is_urgent, pause_s)
            self._changed.wait_for(lambda: self._is_closing or not self._is_paused)
            self._waiting_period_s = min(2 * self._waiting_period_s, _LONGEST_PERIOD_S)
            return not self._is_closing

    def _take_message(self) -> tuple[int, list[bytes]]:
        with self._changed:
            number, self._number = self._number, self._number + 1
            outgoing = list(self._outgoing.values())
            self._outgoing.clear()
            self._is_urgent = False
            return number, outgoing

    def _receive(self, server: Header, answers: list[Piece]) -> None:
        """Store answers. If an answer confirms the end of a stream, remove the stored value of the stream."""
        with self._changed:
            if not self._is_answered:
                self._is_answered = True
                self.connections += 1
            for answer in answers:
                identity = answer.command, answer.key
                self.time_ms = answer.time_ms
                if answer.mode == DISCONTINUE:
                    self._newest.pop(identity, None)
                else:
                    self._newest[identity] = answer
            if server.message != NOTHING_DONE:
                if not self._has_done(server.message):
                    self._last_progress_s = self._clock.now()
                self.server = server
            self._changed.notify_all()

    def _drop_connection(self, failure: RemoteApiError | None = None) -> None:
        with self._changed:
            if self._socket:
                self._socket = self.server = None
                self._is_answered = False
                self._outgoing.clear()
                self._newest.clear()
                self._last_posted = -1
            self.failure = failure
            self._changed.notify_all()
