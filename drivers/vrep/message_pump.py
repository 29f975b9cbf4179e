"""Exchange messages with a server in a separate thread: send queued commands, keep the newest replies."""

from __future__ import annotations

import threading
from collections.abc import Callable

from drivers.vrep.wire.codec import NOTHING_DONE, Header, Piece
from drivers.vrep.wire.errors import NoServerError, RemoteApiError, ServerLostError
from drivers.vrep.wire.link import RETRY_S, Link
from drivers.vrep.wire.requests import DISCONTINUE, Identity, Request
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.threads import start_thread

_WAITING_PERIOD_S = 0.0005
"""Period of messages while a call waits for an answer, in seconds."""


class MessagePump:
    """Exchanges messages with a server in a thread, until it is closed. Its methods may be called from any thread.

    connect: connects to the server.
    period_s: the period of messages in seconds; it is shorter while a call waits for an answer.
    connect_timeout_s: time for further attempts to connect, in seconds, if no server listens or if it closes the
        connection at once.
    reconnects: whether to connect again after the connection was lost. Otherwise the attribute `failure` is set.

    If the connection is lost, queued commands and replies are dropped.
    """

    def __init__(
        self, connect: Callable[[], Link], period_s: float, connect_timeout_s: float, *, reconnects: bool
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
        self._link: Link | None = None
        self._clock = MonotonicClock()
        self._last_progress_s = 0.0
        self.connections = 0
        """The number of connections so far on which the server has answered."""
        self.server: Header | None = None
        self.failure: RemoteApiError | None = None
        self._thread = start_thread(self._run, "remote api")

    @property
    def is_connected(self) -> bool:
        """Whether the server has answered on the present connection."""
        return self._is_answered

    @property
    def number(self) -> int:
        """The number of the next message."""
        return self._number

    @property
    def silence_s(self) -> float:
        """Seconds since the server did its newest command or sent its newest streamed value."""
        return self._clock.now() - self._last_progress_s

    def post(self, request: Request[object], mode: int, delay: int = 0) -> int:
        """Queue a command for the next message. A queued command with the same number and key is replaced.

        mode, delay: see `encode_command`.

        Returns the number of the message.
        """
        with self._changed:
            self._outgoing[request.identity] = request.encode(mode, delay)
            self._last_posted = self._number
            return self._number

    def wait(self, number: int, timeout_s: float) -> bool:
        """Wait until the server has done the commands of the message ``number``; return whether it has in time."""
        with self._changed:
            self._waiters += 1
            self._is_urgent = True
            self._changed.notify_all()
            try:
                self._changed.wait_for(lambda: self._has_done(number) or self._is_over, timeout_s)
            finally:  # a signal may interrupt the wait
                self._waiters -= 1
            return self._has_done(number)

    def wait_connected(self, timeout_s: float) -> bool:
        """Wait until the server has answered on a connection; return whether it has in time."""
        with self._changed:
            self._changed.wait_for(lambda: self.is_connected or self._is_over, timeout_s)
            return self.is_connected

    def newest(self, request: Request[object]) -> Piece | None:
        """Return the newest answer to a request; None if there is none."""
        with self._changed:
            return self._newest.get(request.identity)

    def discard(self, request: Request[object]) -> bool:
        """Drop the newest answer to a request; return whether there was one."""
        with self._changed:
            return self._newest.pop(request.identity, None) is not None

    def set_paused(self, *, is_paused: bool) -> None:
        """Pause or resume sending. One message sends all commands that were posted during a pause."""
        with self._changed:
            self._is_paused = is_paused
            self._changed.notify_all()

    def close(self, timeout_s: float, *, finish: bool = True) -> None:
        """Disconnect, and end the thread.

        timeout_s: time limit in seconds.
        finish: whether to wait first until the server has done all posted commands. Otherwise it drops them.
        """
        self.set_paused(is_paused=False)
        if finish and self._last_posted >= 0:
            self.wait(self._last_posted, timeout_s)
        with self._changed:
            self._is_closing = True
            self._changed.notify_all()
        self._thread.join(timeout_s)
        if link := self._link:
            link.close()
        self._thread.join(timeout_s)

    @property
    def _is_over(self) -> bool:
        return not self._thread.is_alive() or self.failure is not None

    def _has_done(self, number: int) -> bool:
        return self.server is not None and self.server.message >= number

    def _run(self) -> None:
        while not self._is_closing:
            try:
                with self._connect() as link:
                    self._exchange_messages(link)
            except RemoteApiError as failure:
                if not (self._reconnects or self._is_retryable(failure)):
                    self._drop_connection(failure)
                    return
                self._drop_connection()
                with self._changed:
                    self._changed.wait_for(lambda: self._is_closing, RETRY_S)
            self._link = None

    def _is_retryable(self, failure: RemoteApiError) -> bool:
        """Return whether to connect again after this failure.

        After another program has disconnected, a server refuses or closes connections for a short time.
        """
        is_transient = isinstance(failure, (NoServerError, ServerLostError))
        return is_transient and not self.connections and self._clock.now() + RETRY_S <= self._connect_timeout_s

    def _exchange_messages(self, link: Link) -> None:
        with self._changed:
            self._link = link
            self._is_urgent = True
        while self._wait_for_turn():
            number, outgoing = self._take_message()
            self._receive(*link.exchange(number, outgoing))

    def _wait_for_turn(self) -> bool:
        """Wait until the next message is due; return False if the pump is closing."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_closing or self._is_urgent, self._pause_s)
            self._changed.wait_for(lambda: self._is_closing or not self._is_paused)
            return not self._is_closing

    @property
    def _pause_s(self) -> float:
        return min(self._period_s, _WAITING_PERIOD_S) if self._waiters else self._period_s

    def _take_message(self) -> tuple[int, list[bytes]]:
        """Return the number and the commands of the next message."""
        with self._changed:
            number, self._number = self._number, self._number + 1
            outgoing = list(self._outgoing.values())
            self._outgoing.clear()
            self._is_urgent = False
            return number, outgoing

    def _receive(self, server: Header, answers: list[Piece]) -> None:
        """Store the answers. If an answer confirms the end of a stream, remove the stream's value."""
        with self._changed:
            if not self._is_answered:
                self._is_answered = True
                self.connections += 1
            for answer in answers:
                identity = answer.command, answer.key
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
            if self._link:
                self._link = self.server = None
                self._is_answered = False
                self._outgoing.clear()
                self._newest.clear()
                self._last_posted = -1
            self.failure = failure
            self._changed.notify_all()
