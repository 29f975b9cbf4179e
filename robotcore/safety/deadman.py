"""The deadman: it stops the motors if the command was not renewed within one lease."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from threading import RLock

from robotcore.hal.clock import Clock
from robotcore.safety.thread_reserve import Reserve
from robotcore.threads import is_out_of_memory

LOCK_TIMEOUT_S = 0.05
"""The longest wait for a lock, in seconds. After it, the driver call that holds the lock counts as hung."""


class TimedLock:
    """A context that acquires a lock. It waits at most `LOCK_TIMEOUT_S`, and then goes on without the lock."""

    __slots__ = ("_is_held", "_lock")

    def __init__(self, lock: RLock) -> None:
        self._lock = lock

    def __enter__(self) -> None:
        self._is_held = self._lock.acquire(timeout=LOCK_TIMEOUT_S)

    def __exit__(self, *_: object) -> None:
        if self._is_held:
            self._lock.release()


MIN_LEASE_S = 0.1
"""The shortest lease, in seconds. A shorter lease could end while the process waits for a processor."""


class Deadman:
    """Stops the motors if ``lease`` seconds have passed since the last call of `renew`.

    clock: the clock that measures the lease. It may call ``stop`` from another thread.
    lease: the duration of a lease, in seconds. A shorter one is raised to `MIN_LEASE_S`.
    stop: a function that stops the motors. Its argument is the time in seconds.
    lock: the lock that the caller of `renew` and `end_lease` holds. The deadman waits for it for `LOCK_TIMEOUT_S`.
    reserve: the reserved memory that a stop may need.

    >>> from robotcore.hal.clock import SteppedClock
    >>> clock = SteppedClock(20, lambda _: None)
    >>> stop = lambda time: print(f"stop at {time:.2f} s")
    >>> deadman = Deadman(clock, 0.2, stop, RLock(), Reserve(clock))
    >>> deadman.renew(clock.now())
    >>> deadman
    Deadman(lease=0.2, expiry=0.2)
    >>> _ = clock.sleep_until(0.15)
    >>> deadman.renew(clock.now())
    >>> _ = clock.sleep_until(1.0)
    stop at 0.35 s
    """

    def __init__(
        self, clock: Clock, lease: float, stop: Callable[[float], None], lock: RLock, reserve: Reserve
    ) -> None:
        self.lease = max(lease, MIN_LEASE_S)
        self._clock = clock
        self._stop = stop
        self._lock = lock
        self._reserve = reserve
        self._expiry: float | None = None
        self._is_call_due = False
        """Whether a call of `_check` by the clock is still to come."""

    def __repr__(self) -> str:
        return f"Deadman(lease={self.lease:g}, expiry={self._expiry})"

    def renew(self, now: float) -> None:
        """Begin a new lease at the time ``now``, in seconds."""
        self._expiry = now + self.lease
        if not self._is_call_due:
            self._call_later(self._expiry)

    def end_lease(self) -> None:
        """End the lease, so that the deadman does nothing. The caller must have stopped the motors."""
        self._expiry = None

    def _call_later(self, expiry: float) -> None:
        # If call_at raises, the next `renew` calls it again.
        self._is_call_due = True
        try:
            check = partial(self._check, expiry)
            self._clock.call_at(expiry, partial(self._reserve.retry_on_memory_error, check))
        except BaseException:
            self._is_call_due = False
            raise

    def _check(self, called_at: float) -> None:
        with TimedLock(self._lock):
            self._is_call_due = False
            if self._expiry is None:
                return
            if self._expiry <= called_at or not self._try_to_call_later(self._expiry):
                self._end_and_stop(called_at)

    def _try_to_call_later(self, expiry: float) -> bool:
        # If memory runs out, the caller stops the motors early, which is safe.
        try:
            self._call_later(expiry)
        except Exception as error:
            if not is_out_of_memory(error):
                raise
            return False
        return True

    def _end_and_stop(self, called_at: float) -> None:
        # If memory runs out, the lease stays, so that the next call tries again.
        expiry, self._expiry = self._expiry, None
        try:
            self._stop(called_at)
        except Exception as error:
            if is_out_of_memory(error):
                self._expiry = expiry
            raise
