"""How far a track has come, finer than the whole centimetres that the board tells."""

from __future__ import annotations

from typing import NamedTuple

from drivers.serial.boards.turning import Turning
from drivers.serial.boards.waveshare.protocol import Track

PATIENCE_S = 0.1
"""By so much two lines may come in later, or closer together, than they were told."""

FASTEST_M_S = 3.0
"""No track is faster, downhill too."""


class Odometer:
    """Goes by the measured speed within the centimetre that the board tells, and never leaves that.

    So it is less than 1 cm off, and adds no error up. ``turning`` counts metres, from the first one told on.

    >>> odometer = Odometer()
    >>> for time, centimetres in ((0.0, 0), (0.05, 0), (0.1, 2)):
    ...     odometer.move(Track(centimetres, 0.1), time)
    ...     print(f"{odometer.turning.angle(1.0).angle:g} m")
    0 m
    0.005 m
    0.02 m
    """

    def __init__(self) -> None:
        self.turning = Turning()
        self._last: _Place | None = None

    def restart(self) -> None:
        """Know that the board may count from anywhere now."""
        self.turning.restart()
        self._last = None

    def is_likely(self, told: Track, time: float) -> bool:
        """Return whether it can have come so far, or a digit was lost on the line."""
        if self._last is None:
            return True
        low, high = _within(told.centimetres)
        farthest = FASTEST_M_S * (time - self._last.time + PATIENCE_S)
        return low - farthest <= self._last.metres <= high + farthest

    def move(self, told: Track, time: float) -> None:
        """Take what the board tells."""
        low, high = _within(told.centimetres)
        guess = (low + high) / 2
        if last := self._last:
            guess = last.metres + (last.speed + told.speed) / 2 * (time - last.time)
        self._last = _Place(min(max(guess, low), high), told.speed, time)
        self.turning.count(self._last.metres, time)


class _Place(NamedTuple):
    metres: float
    speed: float
    time: float


def _within(centimetres: int) -> tuple[float, float]:
    """Return between which metres those are that are cut, towards zero, to so many centimetres."""
    low = centimetres if centimetres > 0 else centimetres - 1
    high = centimetres if centimetres < 0 else centimetres + 1
    return low / 100, high / 100
