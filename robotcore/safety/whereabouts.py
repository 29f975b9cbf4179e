"""Where the loop's thread is, so that a watchdog can tell the app from a driver: a note that costs next to nothing."""

from __future__ import annotations

from collections.abc import Callable
from threading import get_ident, get_native_id
from types import FrameType
from typing import NamedTuple, TypeVar

from robotcore.errors import RobotcoreError

T = TypeVar("T")
ToldT = TypeVar("ToldT")


class Stay(NamedTuple):
    """Somewhere the thread should not be for longer than ``limit_s``.

    ``error`` makes the error of its having been there for so many seconds, given the thread's innermost frame.
    ``grace_s`` is how long the thread may take to come back when it was called back.
    """

    limit_s: float
    error: Callable[[float, FrameType | None], RobotcoreError]
    grace_s: float


class Whereabouts:
    """What the thread that made this is doing, and which driver's call it is in.

    ``moves`` grows with each change of ``doing``, ``calls`` with each call that is begun: where they stand still, so
    does the thread. ``ticks`` are those that were begun.
    """

    __slots__ = ("call", "calls", "doing", "moves", "native_thread", "thread", "ticks")

    def __init__(self) -> None:
        self.thread, self.native_thread = get_ident(), get_native_id()
        self.doing: Stay | None = None
        self.call: Stay | None = None
        self.moves = self.calls = self.ticks = 0

    def begin(self, doing: Stay | None) -> None:
        """Note what the thread does from now on; None is not watched."""
        self.doing = doing
        self.moves += 1

    def asking(self, call: Stay, function: Callable[[], T]) -> T:
        """Call a driver's function; what other threads do is not noted."""
        if get_ident() != self.thread:
            return function()
        before, self.call = self.call, call
        self.calls += 1
        try:
            return function()
        finally:
            self.call = before

    def telling(self, call: Stay, function: Callable[[ToldT], T], told: ToldT) -> T:
        """Do as `asking` does for a function that is told something: so both cost a third less than one for any."""
        if get_ident() != self.thread:
            return function(told)
        before, self.call = self.call, call
        self.calls += 1
        try:
            return function(told)
        finally:
            self.call = before
