"""A connection for lockstep, in which the simulator waits for a trigger before each time step."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Any, TypeVar

from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import NOTHING_DONE, Header, Piece
from drivers.vrep.wire.errors import RemoteApiError, ServerLostError, ServerTimeoutError, SimulationHaltedError
from drivers.vrep.wire.message_socket import CONNECT_TIMEOUT_S, RETRY_S, TIMEOUT_S, MessageSocket
from drivers.vrep.wire.requests import Identity, Request
from robotcore.hal.wall_clock import MonotonicClock


class PendingRequests:
    """Requests that read values, and the answers that the server has sent so far.

    reads: the requests.
    trigger: the number of the message that triggered a time step; None if the values are read without a step.

    After a trigger, an answer counts only if the server has read the value after the time step. Otherwise the request
    is sent again.
    """

    def __init__(self, reads: Sequence[Request[Any]], trigger: int | None = None) -> None:
        self._reads = {read.identity: read for read in reads}
        self._trigger = trigger
        self._step_start_ms = None if trigger is not None else -1
        self._sent: dict[Identity, int] = {}
        self._replies: dict[Identity, Piece] = {}

    @property
    def is_complete(self) -> bool:
        return len(self._replies) == len(self._reads)

    def __getitem__(self, read: Request[Any]) -> Piece:
        return self._replies[read.identity]

    def take_unsent(self, number: int) -> list[Request[Any]]:
        """Return the requests that the next message must contain.

        number: the number of this message.
        """
        unsent = {key: read for key, read in self._reads.items() if key not in self._replies and key not in self._sent}
        self._sent.update(dict.fromkeys(unsent, number))
        return list(unsent.values())

    def receive(self, server: Header, pieces: Iterable[Piece]) -> None:
        """Add the answers of a reply. Raises SimulationHaltedError if the simulation cannot advance.

        server: the header of the reply.
        pieces: the answers.
        """
        for piece in pieces:
            if (piece.command, piece.key) == requests.TRIGGER.identity:
                self._start_step(server, piece)
            else:
                self._receive_piece(server, piece)
        if self._trigger is not None and server.message >= self._trigger:
            self._check_state(server)

    def _start_step(self, server: Header, piece: Piece) -> None:
        if self._trigger is not None and server.message >= self._trigger:
            if piece.is_failed:
                raise SimulationHaltedError(
                    "the simulator cannot advance the simulation. It is stopped, or does not wait for triggers. Run "
                    "again",
                    kind="trigger-refused",
                )
            self._step_start_ms = piece.time_ms

    def _receive_piece(self, server: Header, piece: Piece) -> None:
        identity = piece.command, piece.key
        if server.message < self._sent.get(identity, server.message + 1):
            return
        del self._sent[identity]
        if self._step_start_ms is not None and piece.time_ms > self._step_start_ms:
            self._replies[identity] = piece

    def _check_state(self, server: Header) -> None:
        if self.is_complete:
            return
        if not server.is_running:
            raise SimulationHaltedError(
                "the simulation was stopped, so its time does not advance. Run again to restart it",
                kind="simulation-stopped",
            )
        if server.is_paused:
            raise SimulationHaltedError(
                "the simulation is paused, so its time does not advance. Resume it, and run again",
                kind="simulation-paused",
            )


T = TypeVar("T")

_SHORTEST_PAUSE_S, _LONGEST_PAUSE_S = 0.0005, 0.004
"""The shortest and the longest pause between two messages to a busy simulator, in seconds."""


@dataclass(frozen=True)
class Step:
    """The result of a time step."""

    time_s: float
    """The simulation's time after the time step, in seconds."""
    values: tuple[Any, ...]
    """The values after the time step, in the order of the requests."""


class LockstepConnection:
    """A connection that exchanges messages only while one of its methods runs. Calls from several threads take turns.

    socket: the TCP connection.
    timeout_s: time limit of a request, in seconds.

    The server replies to a message at once, with the answers that are new since its previous reply. The main thread of
    the simulator executes the requests of a message later, between two time steps. So a value takes two round trips,
    one for the request and one for the answer. A time step takes three:

    1. Send all commands and the trigger.
    2. Receive the confirmation that the step has begun, and request the values after the step.
    3. Receive these values.

    While the simulator is busy, the connection sends empty messages with growing pauses.
    """

    def __init__(self, socket: MessageSocket, timeout_s: float) -> None:
        self._socket, self._timeout_s = socket, timeout_s
        self._clock = MonotonicClock()
        self._number = 0
        self._lock = threading.RLock()
        self._queue_lock = threading.Lock()
        self._queued: dict[Identity, Request[None]] = {}
        self._unconfirmed: dict[Identity, Request[None]] = {}
        self._time_ms = 0
        self.server: Header
        self._exchange(())

    @classmethod
    def open(
        cls, host: str, port: int, timeout_s: float = TIMEOUT_S, connect_timeout_s: float = CONNECT_TIMEOUT_S
    ) -> LockstepConnection:
        """Connect to a server.

        timeout_s: time limit of a request, in seconds.
        connect_timeout_s: the time during which to try again, in seconds. For a short time after another program has
            disconnected, a server may not listen, or may close a new connection at once.
        """
        clock = MonotonicClock()
        while True:
            socket = MessageSocket.open(host, port, timeout_s, connect_timeout_s - clock.now())
            try:
                return cls(socket, timeout_s)
            except ServerLostError:
                socket.close()
                if clock.now() + RETRY_S > connect_timeout_s:
                    raise
            except BaseException:
                socket.close()
                raise
            clock.sleep_until(clock.now() + RETRY_S)

    def __repr__(self) -> str:
        return f"<LockstepConnection, {'lost' if self.is_lost else 'open'}, {self.round_trips} round trips>"

    @property
    def time_s(self) -> float:
        """The simulation's time in the newest answer, in seconds, rounded to milliseconds. It is 0 after a stop."""
        return self._time_ms / 1000

    @property
    def is_lost(self) -> bool:
        """Whether the connection is broken or closed."""
        return self._socket.is_closed

    @property
    def round_trips(self) -> int:
        """The number of replies that the server has sent."""
        return self._socket.exchanges

    def post(self, request: Request[None]) -> None:
        """Queue a command for the next message. It replaces a queued command with the same number and key.

        This method never waits, not even for a time step in another thread. So wheels can always be stopped. If the
        server refuses the command, the later call that receives the answer raises RefusedError.
        """
        with self._queue_lock:
            self._queued[request.identity] = request

    def call(self, request: Request[T]) -> T:
        """Send the queued commands and a request, and return the value of the answer.

        Raises RefusedError if the server refuses the request or a command.
        """
        with self._lock:
            self._send_queued()
            return request.read(self._fetch(PendingRequests([request]))[request])

    def step(self, *reads: Request[Any]) -> Step:
        """Send the queued commands, trigger one time step, and return the values after it.

        reads: the requests that read the values.

        The simulation must wait for triggers (see `wait_for_triggers`), and its time step must be at least 1 ms. Raises
        SimulationHaltedError if the simulation is stopped or paused.
        """
        with self._lock:
            number = self._send_queued(requests.TRIGGER)
            pending = self._fetch(PendingRequests(reads or (requests.CLOCK,), number))
            return Step(self.time_s, tuple(read.read(pending[read]) for read in reads))

    def wait_for_triggers(self, *, wait: bool) -> None:
        """Set whether the simulation waits for a trigger before each time step."""
        self.call(requests.SYNCHRONOUS_ON if wait else requests.SYNCHRONOUS_OFF)

    def start(self) -> None:
        """Start or resume the simulation, and return when it runs."""
        self.call(requests.START)
        self._await_state("started", lambda server: server.is_running and not server.is_paused)

    def stop(self) -> None:
        """Stop the simulation, and return when it has stopped."""
        self.call(requests.STOP)
        self._await_state("stopped", lambda server: not server.is_running)

    def close(self) -> None:
        """Wait until the server has executed the queued commands, and disconnect."""
        with self._lock:
            with suppress(RemoteApiError):
                if self._queued or self._unconfirmed:
                    self.call(requests.CLOCK)
            self._socket.close()

    def __enter__(self) -> LockstepConnection:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _send_queued(self, *more: Request[None]) -> int:
        with self._queue_lock:
            queued, self._queued = self._queued, {}
        self._unconfirmed |= queued
        return self._exchange([*queued.values(), *more]) if queued or more else self._number

    def _fetch(self, pending: PendingRequests) -> PendingRequests:
        deadline = self._clock.now() + self._timeout_s
        for pause_s in _iterate_pauses():
            self._exchange(pending.take_unsent(self._number), pending)
            if pending.is_complete:
                break
            if self._clock.now() > deadline:
                raise self._timeout_error("executed the request")
            if self.server.message == NOTHING_DONE:
                self._clock.sleep_until(self._clock.now() + pause_s)
        return pending

    def _await_state(self, participle: str, is_reached: Callable[[Header], bool]) -> None:
        deadline = self._clock.now() + self._timeout_s
        while not is_reached(self.server):
            if self._clock.now() > deadline:
                raise self._timeout_error(f"{participle} the simulation")
            self.call(requests.CLOCK)

    def _timeout_error(self, action: str) -> ServerTimeoutError:
        return ServerTimeoutError(
            f"the simulator answers, but has not {action} within {self._timeout_s:g} s. "
            "Check whether it shows a dialogue, or waits for a trigger of another program",
            kind="simulator-busy",
            timeout_s=self._timeout_s,
        )

    def _exchange(self, outgoing: Iterable[Request[Any]], pending: PendingRequests | None = None) -> int:
        number, self._number = self._number, self._number + 1
        self.server, pieces = self._socket.exchange(number, [request.encode() for request in outgoing])
        if pieces:
            self._time_ms = pieces[-1].time_ms
        for piece in pieces:
            if request := self._unconfirmed.pop((piece.command, piece.key), None):
                request.read(piece)
        if pending:
            pending.receive(self.server, pieces)
        return number


def _iterate_pauses() -> Iterator[float]:
    pause_s = _SHORTEST_PAUSE_S
    while True:
        yield pause_s
        pause_s = min(2 * pause_s, _LONGEST_PAUSE_S)
