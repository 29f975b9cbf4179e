"""How far a wheel has turned, by a board that counts from zero again whenever it was reset."""

from __future__ import annotations

from robotcore.hal.devices import Angle


class Turning:
    """Adds up what a board counts of one wheel, in the board's own unit, from the first count on.

    After `restart` the next count is taken to be where the last one was: what the wheel turned meanwhile nobody knows,
    and nothing is made up for it. ``wraps_at`` is how many counts the board's counter has before it begins anew, 2³²
    for a 32-bit one. One thread counts, others ask for the angle.

    >>> turning = Turning(wraps_at=2**32)
    >>> for time, count in enumerate((2**31 - 1, -(2**31) + 1)):
    ...     turning.count(count, time)
    >>> turning.angle(rad_per_unit=0.5)
    Angle(angle=1.0, time=1, sequence=1)
    """

    def __init__(self, wraps_at: float | None = None) -> None:
        self._wraps_at = wraps_at
        self._last: float | None = None
        self._newest: tuple[float, float, int] | None = None

    def count(self, counted: float, time: float) -> None:
        """Take what the board's counter is at ``time``, when its frame came in."""
        total, _, sequence = self._newest or (0.0, 0.0, -1)
        total += self._turned(counted)
        self._last = counted
        self._newest = total, time, sequence + 1

    def restart(self) -> None:
        """Know that the board may count from anywhere now."""
        self._last = None

    def angle(self, rad_per_unit: float) -> Angle | None:
        """Return the wheel's angle, as old as the newest count; None where there was none."""
        if self._newest is None:
            return None
        total, time, sequence = self._newest
        return Angle(total * rad_per_unit, time, sequence)

    def _turned(self, counted: float) -> float:
        if self._last is None:
            return 0.0
        turned = counted - self._last
        if self._wraps_at:
            turned = (turned + self._wraps_at / 2) % self._wraps_at - self._wraps_at / 2
        return turned
