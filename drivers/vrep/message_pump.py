"""Exchange messages with a server on a thread of its own: send what is queued, keep the newest replies."""

from __future__ import annotations

import threading
from collections.abc import Callable

from drivers.vrep.wire.codec import NOTHING_DONE, Header, Piece
from drivers.vrep.wire.errors import NobodyListensError, RemoteApiError, ServerLostError
from drivers.vrep.wire.link import RETRY_S, Link
from drivers.vrep.wire.requests import DISCONTINUE, Identity, Request
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.threads import start_thread

_ASKING_S = 0.0005
"""How often a server is asked while somebody waits for its answer."""


class MessagePump:
    """Exchanges messages with whatever ``connect`` connects to, at most every ``period_s``, until it is closed.

    Whoever waits for an answer makes it ask more often. Where nobody listens at first, or the server
    hangs up before it has answered, it tries again for ``patience_s``. If the line breaks, everything is forgotten;
    where it ``reconnects``, it tries again, else it says why in `failure`. All methods may be called from any thread.
    """

    def __init__(self, connect: Callable[[], Link], period_s: float, patience_s: float, *, reconnects: bool) -> None:
        self._connect, self._period_s, self._patience_s = connect, period_s, patience_s
        self._reconnects = reconnects
        self._changed = threading.Condition()
        self._outgoing: dict[Identity, bytes] = {}
        self._newest: dict[Identity, Piece] = {}
        self._number = 0
        self._last_asked = -1
        self._waiters = 0
        self._is_urgent = self._is_held = self._is_closing = self._is_answered = False
        self._link: Link | None = None
        self._clock = MonotonicClock()
        self._heard_s = 0.0
        self.connections = 0
        self.server: Header | None = None
        self.failure: RemoteApiError | None = None
        self._thread = start_thread(self._run, "remote api")

    @property
    def is_connected(self) -> bool:
        """Whether the server has answered on the line that there is."""
        return self._is_answered

    @property
    def number(self) -> int:
        """The number of the next message."""
        return self._number

    @property
    def silence_s(self) -> float:
        """How long the server has not done anything that was asked of it, streams included."""
        return self._clock.now() - self._heard_s

    def post(self, request: Request[object], mode: int, delay: int = 0) -> int:
        """Send with the next message, in place of what is of the same identity; return the message's number."""
        with self._changed:
            self._outgoing[request.identity] = request.encoded(mode, delay)
            self._last_asked = self._number
            return self._number

    def wait(self, number: int, timeout_s: float) -> bool:
        """Wait until the server has done the message of that number; return whether it has."""
        with self._changed:
            self._waiters += 1
            self._is_urgent = True
            self._changed.notify_all()
            try:
                self._changed.wait_for(lambda: self._has_done(number) or self._is_over, timeout_s)
            finally:  # a signal may interrupt who waits
                self._waiters -= 1
            return self._has_done(number)

    def wait_connected(self, timeout_s: float) -> bool:
        """Wait until it is connected; return whether it is."""
        with self._changed:
            self._changed.wait_for(lambda: self.is_connected or self._is_over, timeout_s)
            return self.is_connected

    def newest(self, request: Request[object]) -> Piece | None:
        """Return the newest answer that has come to such a request."""
        with self._changed:
            return self._newest.get(request.identity)

    def forget(self, request: Request[object]) -> bool:
        """Drop the newest answer to such a request; return whether there was one."""
        with self._changed:
            return self._newest.pop(request.identity, None) is not None

    def hold(self, *, held: bool) -> None:
        """Send nothing for a while, so that all that is posted in it goes out in one message."""
        with self._changed:
            self._is_held = held
            self._changed.notify_all()

    def close(self, timeout_s: float, *, finish: bool = True) -> None:
        """Have all done that was posted, since a server forgets what it has not done by then; hang up; end the thread.

        A server that hangs is hung up on after ``timeout_s``; unless it is to ``finish``, so is any at once.
        """
        self.hold(held=False)
        if finish and self._last_asked >= 0:
            self.wait(self._last_asked, timeout_s)
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
                    self._talk(link)
            except RemoteApiError as failure:
                if not (self._reconnects or self._may_try_again(failure)):
                    self._lose(failure)
                    return
                self._lose()
                with self._changed:
                    self._changed.wait_for(lambda: self._is_closing, RETRY_S)
            self._link = None

    def _may_try_again(self, failure: RemoteApiError) -> bool:
        """Return whether another program may just have left: for a while its server takes nobody, or hangs up."""
        is_fleeting = isinstance(failure, (NobodyListensError, ServerLostError))
        return is_fleeting and not self.connections and self._clock.now() + RETRY_S <= self._patience_s

    def _talk(self, link: Link) -> None:
        with self._changed:
            self._link = link
            self._is_urgent = True
        while self._await_turn():
            number, outgoing = self._taken()
            self._merge(*link.exchange(number, outgoing))

    def _await_turn(self) -> bool:
        """Wait until the next message is due; return whether it is, and it is not closing instead."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_closing or self._is_urgent, self._pause_s)
            self._changed.wait_for(lambda: self._is_closing or not self._is_held)
            return not self._is_closing

    @property
    def _pause_s(self) -> float:
        return min(self._period_s, _ASKING_S) if self._waiters else self._period_s

    def _taken(self) -> tuple[int, list[bytes]]:
        """Return the next message."""
        with self._changed:
            number, self._number = self._number, self._number + 1
            outgoing = list(self._outgoing.values())
            self._outgoing.clear()
            self._is_urgent = False
            return number, outgoing

    def _merge(self, server: Header, answers: list[Piece]) -> None:
        """Take what has come. The answer to the end of a stream is the end of what is known of it."""
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
                    self._heard_s = self._clock.now()
                self.server = server
            self._changed.notify_all()

    def _lose(self, failure: RemoteApiError | None = None) -> None:
        with self._changed:
            if self._link:
                self._link = self.server = None
                self._is_answered = False
                self._outgoing.clear()
                self._newest.clear()
                self._last_asked = -1
            self.failure = failure
            self._changed.notify_all()
