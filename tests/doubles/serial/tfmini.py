"""A double of a TFmini-S, which sends a frame with the distance every 10 ms."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

from tests.doubles.serial.board import BoardDouble

PERIOD_S = 0.01
SLACK_S = 1e-9
"""The tolerance of times, because sums of floats are not exact."""

REACH_M = 12.0
STRONG, WEAK = 1000, 20
WARM = (36 + 256) * 8
WEAK_CM, SATURATED_CM, DAZZLED_CM = 0xFFFF, 0xFFFE, 0xFFFC


def frame(distance_cm: int, amplitude: int = STRONG, temperature: int = WARM) -> bytes:
    """Return the nine bytes of a measurement. Source: SJ-PM-TFmini-S A00, 5.3.

    temperature: the number in the frame, in eighths of a degree above -256 °C.
    """
    body = b"\x59\x59" + struct.pack("<HHH", distance_cm, amplitude, temperature)
    return body + bytes([sum(body) & 0xFF])


class TFminiS(BoardDouble):
    """A double of a TFmini-S.

    distance: returns the distance to the target in metres; `inf` without a target.
    """

    def __init__(self, distance: Callable[[], float] = lambda: math.inf) -> None:
        self._distance, self._due = distance, 0.0
        self.is_blind = False
        """Whether no light comes back."""
        self.replacement: bytes | None = None
        """Bytes that are sent in place of the frames; None sends the frames."""

    def receive(self, data: bytes, now: float) -> bytes:
        return b""

    def live(self, now: float, seconds: float) -> bytes:
        if now < self._due:
            return b""
        self._due = now + PERIOD_S - SLACK_S
        return self._measure() if self.replacement is None else self.replacement

    def _measure(self) -> bytes:
        distance = math.inf if self.is_blind else self._distance()
        return frame(WEAK_CM, WEAK) if distance > REACH_M else frame(round(distance * 100))
