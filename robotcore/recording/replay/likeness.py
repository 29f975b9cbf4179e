"""Whether two commands are the same."""

from __future__ import annotations

import math
import struct

Command = tuple[float, ...]
"""Of one motor or of both wheels, rad/s."""

ACROSS_PLATFORMS = 1e-9
"""So far commands may differ, in rad/s, where another processor or library has reckoned them."""


class Likeness:
    """Compares commands to the bit, or within a ``tolerance``; ``largest`` is the largest difference it has let pass.

    ``is_exact`` says whether all were equal to the bit so far, NaN counting as equal to NaN.
    """

    def __init__(self, tolerance: float = 0.0) -> None:
        self._tolerance = tolerance
        self.largest = 0.0
        self.is_exact = True

    def __call__(self, one: Command | None, other: Command | None) -> bool:
        """Return whether they are alike; None, which is a stop or no command at all, is like None alone."""
        if one is None or other is None:
            return one is other
        if all(map(_is_same, one, other)):
            return True
        difference = max(map(_difference, one, other))
        is_alike = 0 < self._tolerance >= difference
        if is_alike:
            self.is_exact, self.largest = False, max(self.largest, difference)
        return is_alike


def _is_same(one: float, other: float) -> bool:
    return struct.pack("<d", one) == struct.pack("<d", other) or (math.isnan(one) and math.isnan(other))


def _difference(one: float, other: float) -> float:
    """Return how far two numbers are apart; what is not finite is near nothing but itself."""
    if _is_same(one, other) or one == other:
        return 0.0
    return abs(one - other) if math.isfinite(one - other) else math.inf
