"""An end to a library's endless waiting."""

from __future__ import annotations

import math
from typing import Any


class Patience:
    """A bus that raises TimeoutError after so many transactions, unless it is freed by then.

    Setting up a VL53L1X, its library waits for a first measurement for ever.
    """

    def __init__(self, bus: Any, transactions: int) -> None:
        self._bus = bus
        self._left: float = transactions

    def free(self) -> None:
        """Let any number of transactions follow."""
        self._left = math.inf

    def try_lock(self) -> bool:
        """Begin a transaction."""
        if self._left <= 0:
            raise TimeoutError("it does not measure")
        self._left -= 1
        return bool(self._bus.try_lock())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bus, name)
