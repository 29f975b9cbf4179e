"""How those who stop motors wait for a lock: not for ever."""

from __future__ import annotations

from threading import RLock

PATIENCE_S = 0.05


class Patiently:
    """Holds a lock while entered, if it can be had soon; does without where its owner hangs in a vendor's call."""

    __slots__ = ("_is_held", "_lock")

    def __init__(self, lock: RLock) -> None:
        self._lock = lock

    def __enter__(self) -> None:
        self._is_held = self._lock.acquire(timeout=PATIENCE_S)

    def __exit__(self, *_: object) -> None:
        if self._is_held:
            self._lock.release()
