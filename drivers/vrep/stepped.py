"""A scene in lockstep over the legacy remote API: three round trips a step, however much is read."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, TypeVar

from drivers.vrep import requests
from drivers.vrep.connection import Connection
from drivers.vrep.errors import RefusedError, RemoteApiError, ServerHangsError, SimulationHaltedError
from drivers.vrep.messages import Header
from drivers.vrep.request import Identity, Request
from drivers.vrep.scene import STARTS, LegacyScene, moved
from robotcore.scene import Point

T = TypeVar("T")


class SteppedScene(LegacyScene):
    """Reads after each step all that was read since the step before it, so that it costs no round trip of its own.

    What is told is sent with the next step. Positions that were once asked for are read after every step: they tell
    velocities too.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
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
        for attempt in range(STARTS):
            self._said(partial(self._connection.wait_for_triggers, wait=True))
            self._said(self._connection.start)
            try:
                self._connection.step()
            except (ServerHangsError, SimulationHaltedError):
                if attempt == STARTS - 1:
                    raise
                self._said(self._connection.stop)
            else:
                break
        self._step_s = self.time_step()

    def stop(self) -> None:
        self._said(self._connection.stop)

    def time(self) -> float:
        return self._connection.time_s

    def advance(self, steps: int) -> None:
        for left in range(steps - 1, -1, -1):
            positions = {handle: requests.object_position(handle) for handle in self._followed}
            self._followed.update({handle: self.position(handle) for handle in positions})
            reads = {read.identity: read for read in positions.values()}
            if left == 0:
                reads |= self._asked
                self._asked = {}
            step = self._said(partial(self._connection.step, *reads.values()))
            self._read = dict(zip(reads, step.values, strict=False))

    def position(self, handle: int) -> Point:
        there = super().position(handle)
        self._followed.setdefault(handle, there)
        return there

    def velocity(self, handle: int) -> Point:
        return moved(self._followed[handle], self.position(handle), self._step_s)

    def close(self) -> None:
        """Let a simulation that goes on without us go on by itself, and leave."""
        with suppress(RemoteApiError):
            if not self._failure:
                self._connection.wait_for_triggers(wait=False)
        self._connection.close()

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

    def _said(self, talk: Callable[[], T]) -> T:
        """Return what a talk comes to; after one that failed, all fail with the same words."""
        if self._failure:
            raise self._failure
        try:
            return talk()
        except RefusedError:
            raise
        except RemoteApiError as failure:
            self._failure = failure
            raise
