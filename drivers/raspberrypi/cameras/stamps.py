"""When a picture was taken, by the stamp that comes with it."""

from __future__ import annotations

from robotcore.hal.clock import Clock

FRESH_S = 1.0
"""A camera's first stamp is not older, where it counts on the kernel's clock."""


class Stamps:
    """Turns stamps in CLOCK_MONOTONIC, in seconds, into the robot's time.

    A camera whose first stamp is not of the last second counts from somewhere else: then the picture's arrival is
    taken, which is later by exposure and transfer, up to two frames. Every later stamp is believed, however old.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._are_believed: bool | None = None

    def time_of(self, monotonic_s: float) -> float:
        """Return the time of capture, never in the future."""
        now, stamped = self._clock.now(), self._clock.time_of(monotonic_s)
        if self._are_believed is None:
            self._are_believed = now - stamped < FRESH_S
        return stamped if self._are_believed else now
