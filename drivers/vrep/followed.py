"""A scene that goes on by itself: its server sends after each step what was ever asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from drivers.vrep.following import Following, Newest
from drivers.vrep.scene import STARTS, LegacyScene, moved
from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import ServerHangsError
from drivers.vrep.wire.messages import Header
from drivers.vrep.wire.request import Identity, Request
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.simulation.remote_scene import Point

T = TypeVar("T")

_NAP_S = 0.002


class FollowedScene(LegacyScene):
    """Reads what came last, and never waits for what was read before; what is told is on its way at once."""

    def __init__(self, following: Following, answer_s: float) -> None:
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

    def time(self) -> float:
        return self._following.time_s

    def advance(self, steps: int) -> None:
        """Refuse: time passes by itself here."""
        raise BackendError("a simulation that goes on by itself is followed, not stepped")

    def velocity(self, handle: int) -> Point:
        """Return how fast it moves from the newest answer to the next one."""
        request = requests.object_position(handle)
        before = self._stream(request)
        if not self._comes(self._has_moved_since(before, request)):
            raise ServerHangsError(f"the simulation's time has not moved within {self._answer_s:g} s")
        after = self._stream(request)
        return moved(before.value, after.value, after.time_s - before.time_s)

    def close(self) -> None:
        self._following.close()

    def _once(self, request: Request[T]) -> T:
        return self._following.call(request)

    def _newest(self, request: Request[T]) -> T:
        value: T = self._stream(request).value
        return value

    def _tell(self, request: Request[None]) -> None:
        self._following.set(request)

    def _stream(self, request: Request[object]) -> Newest:
        if request.identity not in self._streamed:
            self._following.stream(request)
            self._streamed.add(request.identity)
        return self._following.newest(request)

    def _has_moved_since(self, before: Newest, request: Request[object] = requests.CLOCK) -> Callable[[], bool]:
        return lambda: self._stream(request).time_s != before.time_s

    def _comes(self, is_so: Callable[[], bool]) -> bool:
        """Wait until it is so; return whether it came to be."""
        deadline = self._wall.now() + self._answer_s
        while not (came := is_so()) and self._wall.now() < deadline:
            self._wall.sleep_until(self._wall.now() + _NAP_S)
        return came
