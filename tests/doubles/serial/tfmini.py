"""A TFmini-S at the other end of a line: a frame each hundredth of a second, of what is in front of it."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

PERIOD_S = 0.01
REACH_M = 12.0
STRONG, WEAK = 1000, 20
WARM = (36 + 256) * 8
WEAK_CM, SATURATED_CM, DAZZLED_CM = 0xFFFF, 0xFFFE, 0xFFFC


def frame(distance_cm: int, amplitude: int = STRONG, temperature: int = WARM) -> bytes:
    """Return the nine bytes of a measurement, the temperature as it is sent. Source: SJ-PM-TFmini-S A00, 5.3."""
    body = b"\x59\x59" + struct.pack("<HHH", distance_cm, amplitude, temperature)
    return body + bytes([sum(body) & 0xFF])


class TFminiS:
    """Says what ``distance`` is, in metres, `inf` for nothing; where it ``is_blind`` no light comes back."""

    def __init__(self, say: Callable[[bytes], object], distance: Callable[[], float]) -> None:
        self._say, self._distance = say, distance
        self.is_blind = False

    def tell(self) -> None:
        """Measure and send it, which it does by itself."""
        distance = math.inf if self.is_blind else self._distance()
        self._say(frame(WEAK_CM, WEAK) if distance > REACH_M else frame(round(distance * 100)))
