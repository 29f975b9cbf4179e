"""A scene in lockstep over the legacy remote API: three round trips a step, however much is read."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, TypeVar

from drivers.vrep.connection import Connection, Step
from drivers.vrep.scene import STARTS, LegacyScene, velocity_between
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Header
from drivers.vrep.wire.errors import (
    GarbledReplyError,
    RemoteApiError,
    ServerHangsError,
    ServerLostError,
    SimulationHaltedError,
)
from drivers.vrep.wire.requests import Identity, Request
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.simulation.executor import SerialExecutor
from robotcore.simulation.remote_scene import Point, State

T = TypeVar("T")

_HALTING_S, _NAP_S = 0.3, 0.01
"""A simulation that takes no step any more has come to its stop after this; so often it is asked."""


class SteppedScene(LegacyScene):
    """Reads after each step all that was read since the step before it, so that it costs no round trip of its own.

    What is told is sent with the next step. Positions that were once asked for are read after every step: they tell
    velocities too. A signal interrupts who waits, never what is said: wheels and simulation can be stopped after it.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._executor = SerialExecutor("remote api")
        self._failure: RemoteApiError | None = None
        self._read: dict[Identity, Any] = {}
        self._asked: dict[Identity, Request[Any]] = {}
        self._followed: dict[int, Point] = {}
        self._step_s = 0.0

    @property
    def _server(self) -> Header:
        return self._connection.server

    def start(self) -> None:
        """Start the simulation, and take a step, to see whether time moves."""
        for left in range(STARTS - 1, -1, -1):
            if self._starts(is_last=left == 0):
                break
            self.stop()
        self._step_s = self.read_time_step()

    def stop(self) -> None:
        self._said(self._connection.stop)

    def read_time(self) -> float:
        return self._connection.time_s

    def advance(self, steps: int) -> None:
        for left in range(steps - 1, -1, -1):
            positions = {handle: requests.object_position(handle) for handle in self._followed}
            self._followed.update({handle: self.read_position(handle) for handle in positions})
            reads = {read.identity: read for read in positions.values()}
            if left == 0:
                reads |= self._asked
                self._asked = {}
            step = self._said(partial(self._step, *reads.values()))
            self._read = dict(zip(reads, step.values, strict=False))

    def read_position(self, handle: int) -> Point:
        there = super().read_position(handle)
        self._followed.setdefault(handle, there)
        return there

    def read_velocity(self, handle: int) -> Point:
        return velocity_between(self._followed[handle], self.read_position(handle), self._step_s)

    def close(self) -> None:
        """Let a simulation that goes on without us go on by itself, and leave."""
        with suppress(RemoteApiError):
            self._said(partial(self._connection.wait_for_triggers, wait=False))
        self._executor.run(self._connection.close)
        self._executor.close()

    def _once(self, request: Request[T]) -> T:
        return self._said(partial(self._connection.call, request))

    def _newest(self, request: Request[T]) -> T:
        identity = request.identity
        self._asked[identity] = request
        if identity not in self._read:
            self._read[identity] = self._once(request)
        value: T = self._read[identity]
        return value

    def _tell(self, request: Request[None]) -> None:
        if self._failure:
            raise self._failure
        self._connection.set(request)

    def _step(self, *reads: Request[Any]) -> Step:
        try:
            return self._connection.step(*reads)
        except SimulationHaltedError as failure:
            raise self._why_halted(failure) from failure

    def _starts(self, *, is_last: bool) -> bool:
        """Start and take a step; return whether that worked. Raises why not where the line broke, or it ``is_last``."""
        try:
            self._said(partial(self._connection.wait_for_triggers, wait=True))
            self._said(self._connection.start)
            self._said(self._connection.step)
        except (ServerHangsError, SimulationHaltedError):
            if is_last or self._failure:
                raise
            return False
        return True

    def _why_halted(self, failure: SimulationHaltedError) -> SimulationHaltedError:
        """Return the failure in plainer words, when the server knows them: a stop takes a few steps."""
        wall = MonotonicClock()
        while (state := self.read_state()) is State.RUNNING:
            if wall.now() > _HALTING_S:
                return failure
            wall.sleep_until(wall.now() + _NAP_S)
        return SimulationHaltedError(f"the simulation was {state.value}, so no step can be taken. Run again")

    def _said(self, talk: Callable[[], T]) -> T:
        """Return what a talk comes to; after a line has failed, all fails with the same words."""
        return self._executor.run(partial(self._talked, talk))

    def _talked(self, talk: Callable[[], T]) -> T:
        if self._failure:
            raise self._failure
        try:
            return talk()
        except (ServerHangsError, ServerLostError, GarbledReplyError) as failure:
            if self._connection.is_lost:
                self._failure = failure
            raise
