"""A simulator that runs by itself: its newest values and its time, as they come in."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from threading import Lock
from types import TracebackType
from typing import Any, NamedTuple, TypeVar, cast

from drivers.vrep.mailbox import Mailbox
from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import ServerHangsError, SimulationHaltedError
from drivers.vrep.wire.link import PATIENCE_S, TIMEOUT_S, Link
from drivers.vrep.wire.messages import Header
from drivers.vrep.wire.request import BLOCKING, ONESHOT, STREAMING, Identity, Request
from robotcore.hal.wall_clock import MonotonicClock

T = TypeVar("T")

PERIOD_S = 0.005
"""Between two messages: as long as the maker's tutorials have it."""

_MARGIN_S = 0.3
"""A line that times out is to say why itself, on a busy machine too."""


class Newest(NamedTuple):
    """A value, and the simulation's time in seconds at which it was so."""

    value: Any
    time_s: float


class Following:
    """A connection that a thread keeps going, so that `newest` and `time_s` never wait. For any thread.

    A line that breaks is not mended: everything raises what broke it from then on, and so it does when the simulator
    still answers, but has done nothing for ``timeout_s``.
    """

    def __init__(self, mailbox: Mailbox, timeout_s: float) -> None:
        self._mailbox, self._timeout_s = mailbox, timeout_s
        self._clock = MonotonicClock()
        self._streams: set[Identity] = set()
        self._telling_time, self._told_s = Lock(), 0.0

    @classmethod
    def to(cls, host: str, port: int, timeout_s: float = TIMEOUT_S, patience_s: float = PATIENCE_S) -> Following:
        """Connect to a server that answers; where nobody listens, try again for ``patience_s``."""
        connect = partial(Link.to, host, port, timeout_s)
        mailbox = Mailbox(connect, PERIOD_S, patience_s, reconnects=False)
        following = cls(mailbox, timeout_s)
        try:
            mailbox.wait_connected(patience_s + timeout_s)
            following.stream(requests.CLOCK)
        except BaseException:
            following.close()
            raise
        return following

    @property
    def server(self) -> Header:
        """The newest that the server has said about itself."""
        self._check()
        if (server := self._mailbox.server) is None:
            raise self._late()
        return server

    @property
    def time_s(self) -> float:
        """The simulation's newest time; servers tell whole milliseconds.

        SimulationHaltedError once it is paused or stopped by others, also where it was started again unseen.
        """
        server = self.server
        if not server.is_running:
            raise _halted("stopped")
        if server.is_paused:
            raise _halted("paused")
        with self._telling_time:
            time_s = self.newest(requests.CLOCK).time_s
            if time_s < self._told_s:
                raise _halted("stopped")
            self._told_s = time_s
        return time_s

    def start(self) -> None:
        """Start the simulation, or let it go on, and return when the server says that it runs."""
        self.call(requests.START)
        self._await_state(lambda server: server.is_running and not server.is_paused)

    def stop(self) -> None:
        """Stop the simulation and return when the server says that it has."""
        self.call(requests.STOP)
        self._await_state(lambda server: not server.is_running)
        self._told_s = 0.0

    def stream(self, request: Request[T]) -> T:
        """Have the answer sent again and again from now on; return the first one."""
        value = self._wait_for(request, STREAMING)
        self._streams.add(request.identity)
        return value

    def newest(self, request: Request[Any]) -> Newest:
        """Return the newest answer to a request that is streamed."""
        self._check()
        if (answer := self._mailbox.newest(request)) is None:
            raise ServerHangsError(f"the simulator no longer answers the request to {request.words}. Restart it")
        return Newest(request.read(answer), answer.time_ms / 1000)

    def call(self, request: Request[T]) -> T:
        """Return the answer, waiting for it; of what is streamed, the newest."""
        if request.identity in self._streams:
            return cast("T", self.newest(request).value)
        value = self._wait_for(request, BLOCKING)
        self._mailbox.forget(request)
        return value

    def set(self, request: Request[None]) -> None:
        """Send with the next message. If the server refused the one before, RefusedError is raised now."""
        self._check()
        if earlier := self._mailbox.newest(request):
            request.read(earlier)
        self._mailbox.post(request, ONESHOT)

    def close(self) -> None:
        """Have all done that was sent, unless nothing was done for long enough, and hang up."""
        self._mailbox.close(self._timeout_s, finish=self._mailbox.silence_s <= self._timeout_s)

    def __enter__(self) -> Following:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _wait_for(self, request: Request[T], mode: int) -> T:
        number = self._mailbox.post(request, mode)
        if not self._mailbox.wait(number, self._timeout_s + _MARGIN_S):
            raise self._mailbox.failure or self._late()
        if (answer := self._mailbox.newest(request)) is None:
            raise self._late()
        return request.read(answer)

    def _await_state(self, is_reached: Callable[[Header], bool]) -> None:
        deadline = self._clock.now() + self._timeout_s
        while not is_reached(self.server):
            if self._clock.now() > deadline:
                raise self._late()
            self._mailbox.wait(self._mailbox.number, self._timeout_s)

    def _check(self) -> None:
        if failure := self._mailbox.failure:
            raise failure
        if self._mailbox.silence_s > self._timeout_s:
            raise self._late()

    def _late(self) -> ServerHangsError:
        return ServerHangsError(
            f"the simulator has done nothing for {self._timeout_s:g} s. Does it show a dialog, or wait for another "
            "program's trigger?"
        )


def _halted(how: str) -> SimulationHaltedError:
    return SimulationHaltedError(f"the simulation was {how}: its time does not pass. Let it run, and run again")
