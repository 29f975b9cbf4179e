"""A lock for those who stop motors: they wait for it, but not for ever."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock

PATIENCE_S = 0.05


class PatientLock:
    """A lock that `patiently` goes ahead without, where whoever holds it hangs in a vendor's call."""

    def __init__(self) -> None:
        self._lock = RLock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    @contextmanager
    def patiently(self) -> Iterator[None]:
        """Hold the lock if it can be had soon."""
        is_held = self._lock.acquire(timeout=PATIENCE_S)
        try:
            yield
        finally:
            if is_held:
                self._lock.release()
