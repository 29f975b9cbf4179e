"""A simulator in lockstep: it waits for a trigger before each step, and the program waits for the step's end."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Any, TypeVar

from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import NOTHING_DONE, Header, Piece
from drivers.vrep.wire.errors import RemoteApiError, ServerHangsError, ServerLostError, SimulationHaltedError
from drivers.vrep.wire.link import PATIENCE_S, RETRY_S, TIMEOUT_S, Link
from drivers.vrep.wire.requests import Identity, Request
from robotcore.hal.wall_clock import MonotonicClock


class PendingRequests:
    """The answers to ``reads``; after a step, only those that were given after it.

    An answer counts if the server had our question when it gave it, and, where ``trigger`` is the number of the message
    that triggered a step, if the simulation's time has passed since the trigger was done. What was answered too soon
    is to be asked for again.
    """

    def __init__(self, reads: Sequence[Request[Any]], trigger: int | None = None) -> None:
        self._reads = {read.identity: read for read in reads}
        self._trigger = trigger
        self._begun_ms = None if trigger is not None else -1
        self._asked: dict[Identity, int] = {}
        self._found: dict[Identity, Piece] = {}

    @property
    def are_complete(self) -> bool:
        return len(self._found) == len(self._reads)

    def __getitem__(self, read: Request[Any]) -> Piece:
        return self._found[read.identity]

    def to_ask(self, number: int) -> list[Request[Any]]:
        """Return what to ask for in the message of that number."""
        asked = {one: read for one, read in self._reads.items() if one not in self._found and one not in self._asked}
        self._asked.update(dict.fromkeys(asked, number))
        return list(asked.values())

    def take(self, server: Header, pieces: Iterable[Piece]) -> None:
        """Take what has come; SimulationHaltedError if that says that no step will be taken."""
        for piece in pieces:
            if (piece.command, piece.key) == requests.TRIGGER.identity:
                self._begin(server, piece)
            else:
                self._take(server, piece)
        if self._trigger is not None and server.message >= self._trigger:
            self._check(server)

    def _begin(self, server: Header, piece: Piece) -> None:
        if self._trigger is not None and server.message >= self._trigger:
            if piece.is_failed:
                raise SimulationHaltedError(_NO_STEP)
            self._begun_ms = piece.time_ms

    def _take(self, server: Header, piece: Piece) -> None:
        identity = piece.command, piece.key
        if server.message < self._asked.get(identity, server.message + 1):
            return
        del self._asked[identity]
        if self._begun_ms is not None and piece.time_ms > self._begun_ms:
            self._found[identity] = piece

    def _check(self, server: Header) -> None:
        if self.are_complete:
            return
        if not server.is_running:
            raise SimulationHaltedError("the simulation was stopped: no step can be taken. Run again to start it anew")
        if server.is_paused:
            raise SimulationHaltedError("the simulation is paused: no step can be taken. Let it go on, and run again")


_NO_STEP = "the simulator takes no step: its simulation does not run, or does not wait for our triggers. Run again"


T = TypeVar("T")

_SHORTEST_PAUSE_S, _LONGEST_PAUSE_S = 0.0005, 0.004
"""Between asking a simulator that has nothing new yet and asking it again."""


@dataclass(frozen=True)
class Step:
    """What was read after a step: ``values`` in the order asked for, at ``time_s`` of the simulation."""

    time_s: float
    values: tuple[Any, ...]


class Connection:
    """A connection on which nothing is said unless somebody calls. Calls from several threads take turns.

    The server answers a message at once, with what it has done since the last one; what the message asks for is done by
    its main thread later, between two steps. So a value takes two round trips, and a step three: one to send all
    commands and the trigger; one that learns that the step has begun, and asks for what is to be read after it; one to
    fetch that. While the simulator is still busy it is asked again, a little later each time.
    """

    def __init__(self, link: Link, timeout_s: float) -> None:
        self._link, self._timeout_s = link, timeout_s
        self._clock = MonotonicClock()
        self._number = 0
        self._turn = threading.RLock()
        self._waiting_lock = threading.Lock()
        self._waiting: dict[Identity, Request[None]] = {}
        self._unconfirmed: dict[Identity, Request[None]] = {}
        self._time_ms = 0
        self.server: Header
        self._exchange(())

    @classmethod
    def to(cls, host: str, port: int, timeout_s: float = TIMEOUT_S, patience_s: float = PATIENCE_S) -> Connection:
        """Connect to a server that answers; whatever is asked of it has to be done within ``timeout_s``.

        Where nobody listens, or the first message is hung up on, it tries again for ``patience_s``: so does a server
        that another program has just left.
        """
        clock = MonotonicClock()
        while True:
            link = Link.to(host, port, timeout_s, patience_s - clock.now())
            try:
                return cls(link, timeout_s)
            except ServerLostError:
                link.close()
                if clock.now() + RETRY_S > patience_s:
                    raise
            except BaseException:
                link.close()
                raise
            clock.sleep_until(clock.now() + RETRY_S)

    @property
    def time_s(self) -> float:
        """The simulation's time in the newest answer, 0 while it is stopped; servers tell whole milliseconds."""
        return self._time_ms / 1000

    @property
    def is_lost(self) -> bool:
        """Whether its line has broken, or was closed: nothing is answered any more."""
        return self._link.is_closed

    @property
    def round_trips(self) -> int:
        """How many messages have been answered."""
        return self._link.exchanges

    def set(self, request: Request[None]) -> None:
        """Send with the next message, in place of an earlier one that sets the same and still waits.

        It waits for nobody, not even for a step that another thread has the simulation take: so wheels are stopped.
        Where the server refuses it, the call that learns of it raises RefusedError.
        """
        with self._waiting_lock:
            self._waiting[request.identity] = request

    def call(self, request: Request[T]) -> T:
        """Return the answer, with all that waits done before; RefusedError if it cannot be done."""
        with self._turn:
            self._send_waiting()
            return request.read(self._fetch(PendingRequests([request]))[request])

    def step(self, *reads: Request[Any]) -> Step:
        """Send what waits, let the simulation take one step, and return what is read after it.

        The server has to wait for triggers (`wait_for_triggers`). A simulation that is stopped or paused raises
        SimulationHaltedError. A step shorter than a millisecond cannot be seen.
        """
        with self._turn:
            number = self._send_waiting(requests.TRIGGER)
            answers = self._fetch(PendingRequests(reads or (requests.CLOCK,), number))
            return Step(self.time_s, tuple(read.read(answers[read]) for read in reads))

    def wait_for_triggers(self, *, wait: bool) -> None:
        """Let the server wait for a trigger before each step, or go on by itself."""
        self.call(requests.SYNCHRONOUS_ON if wait else requests.SYNCHRONOUS_OFF)

    def start(self) -> None:
        """Start the simulation, or let it go on, and return when the server says that it runs."""
        self.call(requests.START)
        self._await_state("started", lambda server: server.is_running and not server.is_paused)

    def stop(self) -> None:
        """Stop the simulation and return when the server says that it has."""
        self.call(requests.STOP)
        self._await_state("stopped", lambda server: not server.is_running)

    def close(self) -> None:
        """Have what waits done, since a server forgets what it has not done by then, and hang up."""
        with self._turn:
            with suppress(RemoteApiError):
                if self._waiting or self._unconfirmed:
                    self.call(requests.CLOCK)
            self._link.close()

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _send_waiting(self, *more: Request[None]) -> int:
        """Send what waits, and ``more``; return the message's number."""
        with self._waiting_lock:
            waiting, self._waiting = self._waiting, {}
        self._unconfirmed |= waiting
        return self._exchange([*waiting.values(), *more]) if waiting or more else self._number

    def _fetch(self, answers: PendingRequests) -> PendingRequests:
        """Ask until the answers are complete."""
        deadline = self._clock.now() + self._timeout_s
        for pause_s in _pauses():
            self._exchange(answers.to_ask(self._number), answers)
            if answers.are_complete:
                break
            if self._clock.now() > deadline:
                raise self._too_late("done what it was asked for")
            if self.server.message == NOTHING_DONE:
                self._clock.sleep_until(self._clock.now() + pause_s)
        return answers

    def _await_state(self, word: str, is_reached: Callable[[Header], bool]) -> None:
        deadline = self._clock.now() + self._timeout_s
        while not is_reached(self.server):
            if self._clock.now() > deadline:
                raise self._too_late(f"{word} the simulation")
            self.call(requests.CLOCK)

    def _too_late(self, deed: str) -> ServerHangsError:
        return ServerHangsError(
            f"the simulator answers, but has not {deed} within {self._timeout_s:g} s. "
            "Does it show a dialog, or wait for another program?"
        )

    def _exchange(self, asked: Iterable[Request[Any]], answers: PendingRequests | None = None) -> int:
        """Exchange one message; return its number."""
        number, self._number = self._number, self._number + 1
        self.server, pieces = self._link.exchange(number, [request.encoded() for request in asked])
        if pieces:
            self._time_ms = pieces[-1].time_ms
        for piece in pieces:
            if request := self._unconfirmed.pop((piece.command, piece.key), None):
                request.read(piece)
        if answers:
            answers.take(self.server, pieces)
        return number


def _pauses() -> Iterator[float]:
    """Yield how long to wait before each time a busy simulator is asked again, in seconds."""
    pause_s = _SHORTEST_PAUSE_S
    while True:
        yield pause_s
        pause_s = min(2 * pause_s, _LONGEST_PAUSE_S)
