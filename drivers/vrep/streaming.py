"""A scene without lockstep over the legacy remote API. The server streams values after each time step."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from threading import Lock
from types import TracebackType
from typing import Any, NamedTuple, TypeVar, cast

from drivers.vrep.message_pump import MessagePump
from drivers.vrep.scene import STARTS, LegacyScene, compute_velocity
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Header
from drivers.vrep.wire.errors import ServerTimeoutError, SimulationHaltedError
from drivers.vrep.wire.message_socket import CONNECT_TIMEOUT_S, TIMEOUT_S, MessageSocket
from drivers.vrep.wire.requests import BLOCKING, ONESHOT, STREAMING, Identity, Request
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.simulation.remote_scene import Point

T = TypeVar("T")

PERIOD_S = 0.005
"""The period of messages, in seconds. V-REP's own tutorials use this period."""

_MARGIN_S = 0.3
"""The time by which the time limit of a request exceeds that of a message, in seconds.

If the server fails, the time-out of the message comes first. Its error has more details.
"""


class StreamedValue(NamedTuple):
    """A value that the server has streamed."""

    value: Any
    time_s: float
    """The simulation's time at which the server has read the value, in seconds."""


class StreamReader:
    """Reads values that a server streams. `newest` and `time_s` never wait. Any thread may call the methods.

    pump: exchanges messages with the server in its own thread.
    timeout_s: time limit of a request, in seconds.

    Once the connection is lost, each call raises the error that has ended it. Each call raises ServerTimeoutError if
    the simulator has executed no command and streamed no value for ``timeout_s``.
    """

    def __init__(self, pump: MessagePump, timeout_s: float) -> None:
        self._pump, self._timeout_s = pump, timeout_s
        self._clock = MonotonicClock()
        self._streams: set[Identity] = set()
        self._time_lock, self._last_time_s = Lock(), 0.0

    @classmethod
    def open(
        cls, host: str, port: int, timeout_s: float = TIMEOUT_S, connect_timeout_s: float = CONNECT_TIMEOUT_S
    ) -> StreamReader:
        """Connect to a server.

        timeout_s: time limit of a request, in seconds.
        connect_timeout_s: the time during which to try again if no server listens, in seconds.
        """
        connect = partial(MessageSocket.open, host, port, timeout_s)
        pump = MessagePump(connect, PERIOD_S, connect_timeout_s, reconnects=False)
        reader = cls(pump, timeout_s)
        try:
            pump.wait_connected(connect_timeout_s + timeout_s)
            reader.stream(requests.CLOCK)
        except BaseException:
            reader.close()
            raise
        return reader

    def __repr__(self) -> str:
        state = "connected" if self._pump.is_connected else "disconnected"
        return f"<StreamReader, {state}, {len(self._streams)} streams>"

    @property
    def server(self) -> Header:
        """The header of the newest reply."""
        self._check()
        if (server := self._pump.server) is None:
            raise self._timeout_error()
        return server

    @property
    def time_s(self) -> float:
        """The newest time of the simulation in seconds, rounded to milliseconds.

        Raises SimulationHaltedError if the simulation is paused or stopped, or was restarted since the previous read.
        """
        server = self.server
        if not server.is_running:
            raise _halted_error("stopped")
        if server.is_paused:
            raise _halted_error("paused")
        with self._time_lock:
            time_s = self.newest(requests.CLOCK).time_s
            if time_s < self._last_time_s:
                raise _halted_error("stopped")
            self._last_time_s = time_s
        return time_s

    def start(self) -> None:
        """Start or resume the simulation, and return when it runs."""
        self.call(requests.START)
        self._await_state(lambda server: server.is_running and not server.is_paused)

    def stop(self) -> None:
        """Stop the simulation, and return when it has stopped."""
        self.call(requests.STOP)
        self._await_state(lambda server: not server.is_running)
        self._last_time_s = 0.0

    def stream(self, request: Request[T]) -> T:
        """Make the server stream the value of a request, and return the first value."""
        value = self._wait_for(request, STREAMING)
        self._streams.add(request.identity)
        return value

    def newest(self, request: Request[Any]) -> StreamedValue:
        """Return the newest value of a request for which `stream` was called."""
        self._check()
        if (answer := self._pump.newest(request)) is None:
            raise ServerTimeoutError(
                f"the simulator no longer answers the request to {request.action}. Restart the simulator",
                kind="stream-lost",
            )
        return StreamedValue(request.read(answer), answer.time_ms / 1000)

    def call(self, request: Request[T]) -> T:
        """Send a request, and return the value of its answer.

        If the server streams the answers to this request, return the newest value without waiting.
        """
        if request.identity in self._streams:
            return cast("T", self.newest(request).value)
        value = self._wait_for(request, BLOCKING)
        self._pump.discard(request)
        return value

    def post(self, request: Request[None]) -> None:
        """Queue a command for the next message.

        Raises RefusedError if the server has refused the previous command with the same number and key.
        """
        self._check()
        if earlier := self._pump.newest(request):
            request.read(earlier)
        self._pump.post(request, ONESHOT)

    def close(self) -> None:
        """Disconnect. If the server still answers, wait first until it has executed the queued commands."""
        self._pump.close(self._timeout_s, finish=self._pump.silence_s <= self._timeout_s)

    def __enter__(self) -> StreamReader:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _wait_for(self, request: Request[T], mode: int) -> T:
        number = self._pump.post(request, mode)
        if not self._pump.wait(number, self._timeout_s + _MARGIN_S):
            raise self._pump.failure or self._timeout_error()
        if (answer := self._pump.newest(request)) is None:
            raise self._timeout_error()
        return request.read(answer)

    def _await_state(self, is_reached: Callable[[Header], bool]) -> None:
        deadline = self._clock.now() + self._timeout_s
        while not is_reached(self.server):
            if self._clock.now() > deadline:
                raise self._timeout_error()
            self._pump.wait(self._pump.number, self._timeout_s)

    def _check(self) -> None:
        if failure := self._pump.failure:
            raise failure
        if self._pump.silence_s > self._timeout_s:
            raise self._timeout_error()

    def _timeout_error(self) -> ServerTimeoutError:
        return ServerTimeoutError(
            f"the simulator has executed no command for {self._timeout_s:g} s. Check whether it shows a dialogue, or "
            "waits for a trigger of another program",
            kind="simulator-busy",
            timeout_s=self._timeout_s,
        )


def _halted_error(state: str) -> SimulationHaltedError:
    return SimulationHaltedError(
        f"the simulation was {state}, so its time does not advance. Run again, and do not stop or pause the simulation",
        kind=f"simulation-{state}",
    )


_NAP_S = 0.002


class StreamedScene(LegacyScene):
    """A scene without lockstep. It reads streamed values without waiting, and sends commands at once.

    reader: the connection to the server.
    answer_s: time limit of starting and stopping the simulation, in seconds.
    """

    def __init__(self, reader: StreamReader, answer_s: float) -> None:
        self._reader, self._answer_s = reader, answer_s
        self._wall = MonotonicClock()
        self._streamed: set[Identity] = set()

    @property
    def _header(self) -> Header:
        return self._reader.server

    def start(self) -> None:
        """Start the simulation if it is stopped, and wait until its time advances."""
        for left in range(STARTS - 1, -1, -1):
            self._reader.call(requests.START)
            if self._wait_until(self._has_new_time(self._stream(requests.CLOCK))):
                return
            if left:
                self.stop()
        raise ServerTimeoutError(
            "the simulation was started, but its time does not advance. Stop it in the simulator, and run again"
        )

    def stop(self) -> None:
        self._reader.call(requests.STOP)
        if not self._wait_until(lambda: not self._header.is_running):
            raise ServerTimeoutError(
                f"the simulation has not stopped within {self._answer_s:g} s. Restart the simulator"
            )

    def read_time(self) -> float:
        return self._reader.time_s

    def advance(self, steps: int) -> None:
        """Raise BackendError, because only a simulation in lockstep can be advanced."""
        raise BackendError("a simulation without lockstep cannot be advanced by steps", kind="not-stepped")

    def read_velocity(self, handle: int) -> Point:
        """Return the mean velocity between the newest position and the next one, in m/s."""
        request = requests.object_position(handle)
        before = self._stream(request)
        if not self._wait_until(self._has_new_time(before, request)):
            raise ServerTimeoutError(f"the simulation's time has not advanced within {self._answer_s:g} s")
        after = self._stream(request)
        return compute_velocity(before.value, after.value, after.time_s - before.time_s)

    def close(self) -> None:
        self._reader.close()

    def _execute(self, request: Request[T]) -> T:
        return self._reader.call(request)

    def _read_newest(self, request: Request[T]) -> T:
        value: T = self._stream(request).value
        return value

    def _send_command(self, request: Request[None]) -> None:
        self._reader.post(request)

    def _stream(self, request: Request[object]) -> StreamedValue:
        if request.identity not in self._streamed:
            self._reader.stream(request)
            self._streamed.add(request.identity)
        return self._reader.newest(request)

    def _has_new_time(self, before: StreamedValue, request: Request[object] = requests.CLOCK) -> Callable[[], bool]:
        return lambda: self._stream(request).time_s != before.time_s

    def _wait_until(self, condition: Callable[[], bool]) -> bool:
        deadline = self._wall.now() + self._answer_s
        while not (is_true := condition()) and self._wall.now() < deadline:
            self._wall.sleep_until(self._wall.now() + _NAP_S)
        return is_true
