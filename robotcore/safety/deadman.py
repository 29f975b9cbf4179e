"""The deadman: a command expires after one lease unless it is renewed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from threading import RLock

from robotcore.hal.clock import Clock
from robotcore.safety.thread_reserve import Reserve
from robotcore.threads import is_out_of_memory

LOCK_TIMEOUT_S = 0.05
"""A lock that cannot be acquired within this time is held by a driver call that hangs."""


class TimedLock:
    """A context that holds a lock, or goes on without it after `LOCK_TIMEOUT_S` because its owner hangs."""

    __slots__ = ("_is_held", "_lock")

    def __init__(self, lock: RLock) -> None:
        self._lock = lock

    def __enter__(self) -> None:
        self._is_held = self._lock.acquire(timeout=LOCK_TIMEOUT_S)

    def __exit__(self, *_: object) -> None:
        if self._is_held:
            self._lock.release()


MIN_LEASE_S = 0.1
"""A shorter lease would end while the process waits for a processor."""


class Deadman:
    """Calls ``cut`` when ``lease`` seconds have passed since the last `renew`, between ticks too.

    clock: the lease runs on it. It may call from another thread.
    lease: the duration of a lease, in seconds, at least `MIN_LEASE_S`.
    cut: stops the motors. Its argument is the time of the cut.
    lock: the caller of `renew` and `rest` holds it. The cut waits for it for `LOCK_TIMEOUT_S`.
    reserve: the memory that a cut may need.

    >>> from robotcore.hal.clock import SteppedClock
    >>> clock = SteppedClock(20, lambda _: None)
    >>> cut = lambda time: print(f"stop at {time:.2f} s")
    >>> deadman = Deadman(clock, 0.2, cut, RLock(), Reserve(clock))
    >>> deadman.renew(clock.now())
    >>> deadman
    Deadman(lease=0.2, expiry=0.2)
    >>> _ = clock.sleep_until(0.15)
    >>> deadman.renew(clock.now())
    >>> _ = clock.sleep_until(1.0)
    stop at 0.35 s
    """

    def __init__(self, clock: Clock, lease: float, cut: Callable[[float], None], lock: RLock, reserve: Reserve) -> None:
        self.lease = max(lease, MIN_LEASE_S)
        self._clock = clock
        self._cut = cut
        self._lock = lock
        self._reserve = reserve
        self._expiry: float | None = None
        self._is_waiting = False
        """Whether the clock has a call to make. One call is enough: if it comes too early, it asks for the next."""

    def __repr__(self) -> str:
        return f"Deadman(lease={self.lease:g}, expiry={self._expiry})"

    def renew(self, now: float) -> None:
        """Begin a new lease."""
        self._expiry = now + self.lease
        if not self._is_waiting:
            self._wait(self._expiry)

    def rest(self) -> None:
        """End the lease. Call it after the motors were stopped."""
        self._expiry = None

    def _wait(self, expiry: float) -> None:
        """Ask the clock for a call at ``expiry``. If it raises, the next `renew` asks again."""
        self._is_waiting = True
        try:
            check = partial(self._check, expiry)
            self._clock.call_at(expiry, partial(self._reserve.retry_on_memory_error, check))
        except BaseException:
            self._is_waiting = False
            raise

    def _check(self, called_at: float) -> None:
        with TimedLock(self._lock):
            self._is_waiting = False
            if self._expiry is None:
                return
            if self._expiry <= called_at or not self._can_wait(self._expiry):
                self._cut_now(called_at)

    def _can_wait(self, expiry: float) -> bool:
        """Wait for a later expiry. Return False if memory runs out; the caller then cuts early, which is safe."""
        try:
            self._wait(expiry)
        except Exception as error:
            if not is_out_of_memory(error):
                raise
            return False
        return True

    def _cut_now(self, called_at: float) -> None:
        """End the lease and cut the motors. If memory runs out, restore the lease, so that the next call cuts again."""
        expiry, self._expiry = self._expiry, None
        try:
            self._cut(called_at)
        except Exception as error:
            if is_out_of_memory(error):
                self._expiry = expiry
            raise
