"""The deadman: a command expires after one lease unless it is renewed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from threading import RLock

from robotcore.hal.clock import Clock
from robotcore.safety.reserve import Reserve
from robotcore.threads import is_out_of_memory

LOCK_TIMEOUT_S = 0.05


class TimedLock:
    """Holds a lock while entered, if it can be had soon; does without where its owner hangs in a vendor's call."""

    __slots__ = ("_is_held", "_lock")

    def __init__(self, lock: RLock) -> None:
        self._lock = lock

    def __enter__(self) -> None:
        self._is_held = self._lock.acquire(timeout=LOCK_TIMEOUT_S)

    def __exit__(self, *_: object) -> None:
        if self._is_held:
            self._lock.release()


MIN_LEASE_S = 0.1


class Deadman:
    """Calls ``cut`` when ``lease`` seconds have passed since the last `renew`, between ticks too.

    One call to the clock stands at a time; one that comes too early asks for the next. A clock may call from a thread
    of its own: whoever renews or rests holds ``lock``; the cut waits for it, but not for ever. ``reserve`` has the
    memory that a cut may need.
    """

    def __init__(self, clock: Clock, lease: float, cut: Callable[[float], None], lock: RLock, reserve: Reserve) -> None:
        self.lease = max(lease, MIN_LEASE_S)
        self._clock = clock
        self._cut = cut
        self._lock = lock
        self._reserve = reserve
        self._expiry: float | None = None
        self._is_waiting = False

    def renew(self, now: float) -> None:
        """Begin a new lease."""
        self._expiry = now + self.lease
        if not self._is_waiting:
            self._wait(self._expiry)

    def rest(self) -> None:
        """End the lease: the motors were stopped."""
        self._expiry = None

    def _wait(self, expiry: float) -> None:
        """Have the clock call at ``expiry``; if it cannot, the next `renew` asks again."""
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
        """Wait for a later expiry; return False if memory runs out, for then a cut that comes early is the safe one."""
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
