"""A simulation that runs by itself: the server sends each requested value again after every step."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from threading import Lock
from types import TracebackType
from typing import Any, NamedTuple, TypeVar, cast

from drivers.vrep.message_pump import MessagePump
from drivers.vrep.scene import STARTS, LegacyScene, velocity_between
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Header
from drivers.vrep.wire.errors import ServerHangsError, SimulationHaltedError
from drivers.vrep.wire.link import PATIENCE_S, TIMEOUT_S, Link
from drivers.vrep.wire.requests import BLOCKING, ONESHOT, STREAMING, Identity, Request
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.simulation.remote_scene import Point

T = TypeVar("T")

PERIOD_S = 0.005
"""Between two messages: as long as the maker's tutorials have it."""

_MARGIN_S = 0.3
"""A line that times out is to say why itself, on a busy machine too."""


class NewestReply(NamedTuple):
    """A value, and the simulation's time in seconds at which it was so."""

    value: Any
    time_s: float


class StreamReader:
    """A connection that a thread keeps going, so that `newest` and `time_s` never wait. For any thread.

    A line that breaks is not mended: everything raises what broke it from then on, and so it does when the simulator
    still answers, but has done nothing for ``timeout_s``.
    """

    def __init__(self, mailbox: MessagePump, timeout_s: float) -> None:
        self._mailbox, self._timeout_s = mailbox, timeout_s
        self._clock = MonotonicClock()
        self._streams: set[Identity] = set()
        self._time_lock, self._last_time_s = Lock(), 0.0

    @classmethod
    def to(cls, host: str, port: int, timeout_s: float = TIMEOUT_S, patience_s: float = PATIENCE_S) -> StreamReader:
        """Connect to a server that answers; where nobody listens, try again for ``patience_s``."""
        connect = partial(Link.to, host, port, timeout_s)
        mailbox = MessagePump(connect, PERIOD_S, patience_s, reconnects=False)
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
        with self._time_lock:
            time_s = self.newest(requests.CLOCK).time_s
            if time_s < self._last_time_s:
                raise _halted("stopped")
            self._last_time_s = time_s
        return time_s

    def start(self) -> None:
        """Start the simulation, or let it go on, and return when the server says that it runs."""
        self.call(requests.START)
        self._await_state(lambda server: server.is_running and not server.is_paused)

    def stop(self) -> None:
        """Stop the simulation and return when the server says that it has."""
        self.call(requests.STOP)
        self._await_state(lambda server: not server.is_running)
        self._last_time_s = 0.0

    def stream(self, request: Request[T]) -> T:
        """Have the answer sent again and again from now on; return the first one."""
        value = self._wait_for(request, STREAMING)
        self._streams.add(request.identity)
        return value

    def newest(self, request: Request[Any]) -> NewestReply:
        """Return the newest answer to a request that is streamed."""
        self._check()
        if (answer := self._mailbox.newest(request)) is None:
            raise ServerHangsError(f"the simulator no longer answers the request to {request.words}. Restart it")
        return NewestReply(request.read(answer), answer.time_ms / 1000)

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

    def __enter__(self) -> StreamReader:
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


_NAP_S = 0.002


class StreamedScene(LegacyScene):
    """Reads what came last, and never waits for what was read before; what is told is on its way at once."""

    def __init__(self, following: StreamReader, answer_s: float) -> None:
        self._following, self._answer_s = following, answer_s
        self._wall = MonotonicClock()
        self._streamed: set[Identity] = set()

    @property
    def _server(self) -> Header:
        return self._following.server

    def start(self) -> None:
        """Start the simulation, or find that it runs, and wait until its time moves."""
        for left in range(STARTS - 1, -1, -1):
            self._following.call(requests.START)
            if self._comes(self._has_moved_since(self._stream(requests.CLOCK))):
                return
            if left:
                self.stop()
        raise ServerHangsError("the simulation was started, and its time does not move. Stop it there, and run again")

    def stop(self) -> None:
        self._following.call(requests.STOP)
        if not self._comes(lambda: not self._server.is_running):
            raise ServerHangsError(f"the simulation has not stopped within {self._answer_s:g} s. Restart the simulator")

    def read_time(self) -> float:
        return self._following.time_s

    def advance(self, steps: int) -> None:
        """Refuse: time passes by itself here."""
        raise BackendError("a simulation that goes on by itself is followed, not stepped")

    def read_velocity(self, handle: int) -> Point:
        """Return how fast it moves from the newest answer to the next one."""
        request = requests.object_position(handle)
        before = self._stream(request)
        if not self._comes(self._has_moved_since(before, request)):
            raise ServerHangsError(f"the simulation's time has not moved within {self._answer_s:g} s")
        after = self._stream(request)
        return velocity_between(before.value, after.value, after.time_s - before.time_s)

    def close(self) -> None:
        self._following.close()

    def _once(self, request: Request[T]) -> T:
        return self._following.call(request)

    def _newest(self, request: Request[T]) -> T:
        value: T = self._stream(request).value
        return value

    def _tell(self, request: Request[None]) -> None:
        self._following.set(request)

    def _stream(self, request: Request[object]) -> NewestReply:
        if request.identity not in self._streamed:
            self._following.stream(request)
            self._streamed.add(request.identity)
        return self._following.newest(request)

    def _has_moved_since(self, before: NewestReply, request: Request[object] = requests.CLOCK) -> Callable[[], bool]:
        return lambda: self._stream(request).time_s != before.time_s

    def _comes(self, is_so: Callable[[], bool]) -> bool:
        """Wait until it is so; return whether it came to be."""
        deadline = self._wall.now() + self._answer_s
        while not (came := is_so()) and self._wall.now() < deadline:
            self._wall.sleep_until(self._wall.now() + _NAP_S)
        return came
