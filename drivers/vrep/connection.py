"""A connection to a server: calls, commands, streamed values, and time steps in lockstep."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import partial
from types import TracebackType
from typing import Any, NamedTuple, TypeVar

from drivers.vrep.message_pump import MessagePump
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Header, Piece
from drivers.vrep.wire.errors import ServerTimeoutError, SimulationHaltedError
from drivers.vrep.wire.message_socket import MessageSocket
from drivers.vrep.wire.requests import BLOCKING, ONESHOT, STREAMING, Identity, Request
from robotcore.hal.wall_clock import MonotonicClock

T = TypeVar("T")

TIMEOUT_S = 1.5
"""The default time limit of a request, in seconds.

It is so short that an app stops within two seconds after a server has failed.
"""

CONNECT_TIMEOUT_S = 1.2
"""The default time limit of connecting, in seconds.

It is longer than the half second for which a server does not listen after a client has disconnected.
"""

PERIOD_S = 0.005
"""The period of messages, in seconds. V-REP's own tutorials use this period."""

_MARGIN_S = 0.3
"""The time by which the time limit of a request exceeds that of a message, in seconds.

If the server fails, the time-out of the message comes first. Its error has more details.
"""

_HALTING_S, _NAP_S = 0.3, 0.002
"""Time limit until a simulation that is about to stop has stopped, and the time between two reads, in seconds."""

TIME_STANDS = "the simulation's time has not advanced"
"""The beginning of an error message."""


class TimedValue(NamedTuple):
    """A value, and the simulation's time at which the server has read it."""

    value: Any
    time_s: float
    """The time in seconds, rounded to milliseconds."""


class Connection:
    """A connection to a server. Any thread may call the methods.

    pump: exchanges messages with the server in its own thread.
    timeout_s: time limit of a request, in seconds.

    Once the connection is lost, each call raises the error that has ended it. If the server refuses a posted command,
    a later `call`, `step` or `read_newest` raises RefusedError.

    The main thread of the simulator executes the requests of a message later than the server replies to the message. So
    a value takes two round trips, and a time step with any number of values takes three.
    """

    def __init__(self, pump: MessagePump, timeout_s: float) -> None:
        self._pump, self._timeout_s = pump, timeout_s
        self._clock = MonotonicClock()
        self._lock = threading.RLock()
        self._posted: dict[Identity, Request[None]] = {}
        self._streams: set[Identity] = set()

    @classmethod
    def open(
        cls, host: str, port: int, timeout_s: float = TIMEOUT_S, connect_timeout_s: float = CONNECT_TIMEOUT_S
    ) -> Connection:
        """Connect to a server.

        timeout_s: time limit of a request, in seconds.
        connect_timeout_s: the time during which to try again, in seconds. For a short time after another program has
            disconnected, a server may not listen, or may close a new connection at once.
        """
        connect = partial(MessageSocket.open, host, port, timeout_s)
        pump = MessagePump(connect, PERIOD_S, connect_timeout_s, reconnects=False)
        connection = cls(pump, timeout_s)
        try:
            pump.wait_connected(connect_timeout_s + timeout_s)
            connection.call(requests.CLOCK)
        except BaseException:  # a signal too
            connection.close()
            raise
        return connection

    def __repr__(self) -> str:
        return f"<Connection, {'connected' if self._pump.is_connected else 'disconnected'}>"

    @property
    def is_lost(self) -> bool:
        return self._pump.failure is not None

    @property
    def server(self) -> Header:
        """The header of the newest reply."""
        self._check()
        if (server := self._pump.server) is None:
            raise self._timeout_error()
        return server

    @property
    def time_s(self) -> float:
        """The simulation's time in the newest answer, in seconds, rounded to milliseconds. It is 0 after a stop."""
        return self._pump.time_ms / 1000

    def post(self, request: Request[None]) -> None:
        """Queue a command for the next message. It replaces a queued command with the same number and key.

        This method never waits, not even for a time step in another thread. It does not raise the refusal of an
        earlier command. So wheels can always be stopped.
        """
        self._require_connection()
        self._posted[request.identity] = request
        self._pump.post(request, ONESHOT)

    def call(self, request: Request[T]) -> T:
        """Send a request, and return the value of its answer. If the server streams the value, this does not wait."""
        if request.identity in self._streams:
            value: T = self.read_newest(request).value
            return value
        with self._lock:
            value = request.read(self._fetch(request, BLOCKING))
            self._pump.take(request)
        self._check()
        return value

    def read_newest(self, request: Request[Any]) -> TimedValue:
        """Return the newest streamed value. Only the first call waits, because it makes the server stream the value.

        Raises ServerTimeoutError if the simulator has executed no command and streamed no value for ``timeout_s``.
        """
        if request.identity not in self._streams:
            self._fetch(request, STREAMING)
            self._streams.add(request.identity)
        self._check()
        if self._pump.silence_s > self._timeout_s:
            raise self._timeout_error()
        if (answer := self._pump.newest(request)) is None:
            raise ServerTimeoutError(
                f"the simulator no longer answers the request to {request.action}. Restart the simulator",
                kind="stream-lost",
            )
        return TimedValue(request.read(answer), answer.time_ms / 1000)

    def step(self, *reads: Request[Any]) -> tuple[Any, ...]:
        """Trigger one time step, and return the values after it.

        reads: the requests that read the values.

        The simulation must wait for triggers, and its time step must be at least 1 ms. Raises SimulationHaltedError if
        the simulation is stopped or paused.
        """
        trigger = self._fetch(requests.TRIGGER, ONESHOT)
        self._check()
        if trigger.is_failed:
            self._await_halt()
            raise SimulationHaltedError(
                "the simulator cannot advance the simulation. It is stopped, or does not wait for triggers. Run again",
                kind="trigger-refused",
            )
        deadline = self._clock.now() + self._timeout_s
        wanted = reads or (requests.CLOCK,)
        answers = self._fetch_all(wanted)
        while any(answer.time_ms <= trigger.time_ms for answer in answers):  # read before the step
            self.require_running()
            if self._clock.now() > deadline:
                raise self._stalled_error(TIME_STANDS)
            answers = self._fetch_all(wanted)
        return tuple(read.read(answer) for read, answer in zip(reads, answers, strict=False))

    def wait_for_triggers(self, *, wait: bool) -> None:
        """Set whether the simulation waits for a trigger before each time step."""
        self.call(requests.SYNCHRONOUS_ON if wait else requests.SYNCHRONOUS_OFF)

    def start(self) -> None:
        """Start or resume the simulation, and return when it runs."""
        self.call(requests.START)
        self.await_condition(
            lambda: self.server.is_running and not self.server.is_paused, "the simulation has not started"
        )

    def stop(self) -> None:
        """Stop the simulation, and return when it has stopped."""
        self.call(requests.STOP)
        self.await_condition(lambda: not self.server.is_running, "the simulation has not stopped")
        self.call(requests.CLOCK)  # the newest answer may be from before the stop, and the header of its message later

    def await_condition(self, condition: Callable[[], bool], problem: str) -> None:
        """Send requests until a condition is true. Raises ServerTimeoutError after the time limit of a request.

        problem: the beginning of the error message, such as ``the simulation has not stopped``.
        """
        deadline = self._clock.now() + self._timeout_s
        while not condition():
            if self._clock.now() > deadline:
                raise self._stalled_error(problem)
            self.call(requests.CLOCK)
            self._clock.sleep_until(self._clock.now() + _NAP_S)

    def close(self) -> None:
        """Disconnect. If the server still executes commands, wait first until it has executed the posted ones."""
        self._pump.close(self._timeout_s, finish=self._pump.silence_s <= self._timeout_s)

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _fetch(self, request: Request[Any], mode: int) -> Piece:
        (answer,) = self._fetch_all([request], mode)
        return answer

    def _fetch_all(self, wanted: Sequence[Request[Any]], mode: int = ONESHOT) -> list[Piece]:
        number = max(self._pump.post(request, mode) for request in wanted)
        is_executed = self._pump.wait(number, self._timeout_s + _MARGIN_S)
        answers = [answer for request in wanted if (answer := self._pump.newest(request))]
        if not is_executed or len(answers) < len(wanted):
            raise self._pump.failure or self._timeout_error()
        return answers

    def _require_connection(self) -> None:
        if failure := self._pump.failure:
            raise failure

    def _check(self) -> None:
        self._require_connection()
        for identity, request in list(self._posted.items()):
            if answer := self._pump.take(request):
                self._posted.pop(identity, None)
                request.read(answer)

    def _await_halt(self) -> None:
        """Raise SimulationHaltedError once the simulation is stopped or paused. It may be about to stop."""
        deadline = self._clock.now() + _HALTING_S
        while self._clock.now() < deadline:
            self.require_running()
            self.call(requests.CLOCK)
            self._clock.sleep_until(self._clock.now() + _NAP_S)

    def require_running(self) -> None:
        """Raise SimulationHaltedError if the newest reply says that the simulation is stopped or paused."""
        if not self.server.is_running or self.server.is_paused:
            raise build_halted_error("paused" if self.server.is_paused else "stopped")

    def _timeout_error(self) -> ServerTimeoutError:
        return ServerTimeoutError(
            f"the simulator answers, but has executed no command for {self._timeout_s:g} s. Check whether it shows a "
            "dialogue, or waits for a trigger of another program",
            kind="simulator-busy",
            timeout_s=self._timeout_s,
        )

    def _stalled_error(self, problem: str) -> ServerTimeoutError:
        return ServerTimeoutError(
            f"{problem} within {self._timeout_s:g} s, although the simulator executes commands. Check whether it shows "
            "a message, is too slow, or waits for a trigger of another program",
            kind="simulation-stalled",
            timeout_s=self._timeout_s,
        )


def build_halted_error(state: str) -> SimulationHaltedError:
    """Return the error for a simulation that was stopped or paused.

    state: ``stopped`` or ``paused``.
    """
    return SimulationHaltedError(
        f"the simulation was {state}, so its time does not advance. Run again, and do not stop or pause the simulation",
        kind=f"simulation-{state}",
    )
