"""A scene in lockstep over the legacy remote API. A time step, with all reads after it, takes three round trips."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, TypeVar

from drivers.vrep.connection import LockstepConnection, Step
from drivers.vrep.scene import STARTS, LegacyScene, compute_velocity
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Header
from drivers.vrep.wire.errors import (
    ProtocolError,
    RemoteApiError,
    ServerLostError,
    ServerTimeoutError,
    SimulationHaltedError,
)
from drivers.vrep.wire.requests import Identity, Request
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.simulation.executor import SerialExecutor
from robotcore.simulation.remote_scene import Point, State

T = TypeVar("T")

_HALTING_S, _NAP_S = 0.3, 0.01
"""Time limit until a simulation that is about to stop has stopped, and the time between two reads, in seconds."""


class SteppedScene(LegacyScene):
    """A scene in lockstep.

    `advance` sends the posted commands and triggers the time step. It also requests again all values that the app has
    read since the previous step. So the app's next reads need no further round trips. Once the app has read a position,
    each later step requests it, because velocities are computed from positions.

    A signal such as Ctrl-C interrupts the wait for an answer, but not the exchange of messages. So after a signal, the
    program can still stop the wheels and the simulation.
    """

    def __init__(self, connection: LockstepConnection) -> None:
        self._connection = connection
        self._executor = SerialExecutor("remote api")
        self._failure: RemoteApiError | None = None
        self._values: dict[Identity, Any] = {}
        self._requested: dict[Identity, Request[Any]] = {}
        self._positions: dict[int, Point] = {}
        self._step_s = 0.0

    @property
    def _header(self) -> Header:
        return self._connection.server

    def start(self) -> None:
        """Start the simulation, and simulate one time step to check that the simulation's time advances."""
        for left in range(STARTS - 1, -1, -1):
            if self._try_start(is_last=left == 0):
                break
            self.stop()
        self._step_s = self.read_time_step()

    def stop(self) -> None:
        self._run(self._connection.stop)

    def read_time(self) -> float:
        return self._connection.time_s

    def advance(self, steps: int) -> None:
        for left in range(steps - 1, -1, -1):
            positions = {handle: requests.object_position(handle) for handle in self._positions}
            self._positions.update({handle: self.read_position(handle) for handle in positions})
            reads = {read.identity: read for read in positions.values()}
            if left == 0:
                reads |= self._requested
                self._requested = {}
            step = self._run(partial(self._step, *reads.values()))
            self._values = dict(zip(reads, step.values, strict=False))

    def read_position(self, handle: int) -> Point:
        position = super().read_position(handle)
        self._positions.setdefault(handle, position)
        return position

    def read_velocity(self, handle: int) -> Point:
        return compute_velocity(self._positions[handle], self.read_position(handle), self._step_s)

    def close(self) -> None:
        """End lockstep, so that the simulation runs without triggers, and disconnect."""
        with suppress(RemoteApiError):
            self._run(partial(self._connection.wait_for_triggers, wait=False))
        self._executor.run(self._connection.close)
        self._executor.close()

    def _execute(self, request: Request[T]) -> T:
        return self._run(partial(self._connection.call, request))

    def _read_newest(self, request: Request[T]) -> T:
        identity = request.identity
        self._requested[identity] = request
        if identity not in self._values:
            self._values[identity] = self._execute(request)
        value: T = self._values[identity]
        return value

    def _send_command(self, request: Request[None]) -> None:
        if self._failure:
            raise self._failure
        self._connection.post(request)

    def _step(self, *reads: Request[Any]) -> Step:
        try:
            return self._connection.step(*reads)
        except SimulationHaltedError as failure:
            raise self._explain_halt(failure) from failure

    def _try_start(self, *, is_last: bool) -> bool:
        """Start the simulation, simulate one time step, and return whether both succeeded.

        If the connection is lost, or if this is the last attempt, it raises the error instead of returning False.
        """
        try:
            self._run(partial(self._connection.wait_for_triggers, wait=True))
            self._run(self._connection.start)
            self._run(self._connection.step)
        except (ServerTimeoutError, SimulationHaltedError):
            if is_last or self._failure:
                raise
            return False
        return True

    def _explain_halt(self, failure: SimulationHaltedError) -> SimulationHaltedError:
        """Wait until the simulation has stopped or is paused, and return an error that names its state."""
        wall = MonotonicClock()
        while (state := self.read_state()) is State.RUNNING:
            if wall.now() > _HALTING_S:
                return failure
            wall.sleep_until(wall.now() + _NAP_S)
        return SimulationHaltedError(
            f"the simulation was {state.value}, so its time does not advance. Run again",
            kind=f"simulation-{state.value}",
        )

    def _run(self, exchange: Callable[[], T]) -> T:
        """Exchange messages in the executor's thread. Once the connection is lost, each call raises the same error."""
        return self._executor.run(partial(self._run_unless_failed, exchange))

    def _run_unless_failed(self, exchange: Callable[[], T]) -> T:
        if self._failure:
            raise self._failure
        try:
            return exchange()
        except (ServerTimeoutError, ServerLostError, ProtocolError) as failure:
            if self._connection.is_lost:
                self._failure = failure
            raise
