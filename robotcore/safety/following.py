"""Whether wheels do what they are told: by their encoders, which are all that can know."""

from __future__ import annotations

from collections.abc import Callable
from math import copysign

from robotcore.errors import WheelFaultError
from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
from robotcore.safety.latch import Latch

FOLLOWING = 0.25
"""A wheel that turns this share of what it is told follows: lag, slip and a flat battery take less away."""

ENOUGH_RAD = 1.0
"""What a wheel is told is judged when it comes to this much: of less, lag takes too large a part."""

ENOUGH_COUNTS = 4
"""The same for encoders so coarse that one count is more."""


class WheelsFollow:
    """A rule that changes no command, and trips the latch where a wheel does not follow.

    A wheel is judged by what it was told and what it turned while it was driven one way, for ``patience`` seconds and
    for an angle worth the name. ``told`` and ``turned`` return both wheels' angles in rad; ``count`` is what the
    coarser encoder counts, in rad; ``motors`` and ``encoders`` are the names of the left and the right one.
    """

    cause = "wheel fault"

    def __init__(
        self,
        clock: Clock,
        latch: Latch,
        told: Callable[[], Wheels],
        turned: Callable[[], Wheels],
        motors: tuple[str, str],
        encoders: tuple[str, str],
        patience: float,
        count: float = 0.0,
    ) -> None:
        self._clock, self._latch, self._told, self._turned = clock, latch, told, turned
        enough = max(ENOUGH_RAD, ENOUGH_COUNTS * count)
        self._wheels = [_Followed(*names, patience, enough) for names in zip(motors, encoders, strict=True)]

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        now, told, turned = self._clock.now(), self._told(), self._turned()
        judged = [wheel.judged(now, *each) for wheel, *each in zip(self._wheels, last, told, turned, strict=True)]
        if faults := [fault for fault in judged if fault]:
            self._latch.trip(WheelFaultError(faults))
        return asked


class _Followed:
    """One wheel, and since when it has been driven the way it is."""

    def __init__(self, motor: str, encoder: str, patience: float, enough: float) -> None:
        self._motor, self._encoder, self._patience, self._enough = motor, encoder, patience, enough
        self._begin(0.0, 0.0, 0.0, 0.0)

    def judged(self, now: float, velocity: float, told: float, turned: float) -> str:
        """Return in words what is wrong, or nothing; all angles are from the same instant."""
        sense = copysign(1.0, velocity) if velocity else 0.0
        if sense == 0.0 or sense != self._sense:
            self._begin(now, sense, told, turned)
            return ""
        asked, done, passed = told - self._told, turned - self._turned, now - self._since
        if passed < self._patience or abs(asked) < self._enough:
            return ""
        self._begin(now, sense, told, turned)
        if done * sense >= FOLLOWING * abs(asked):
            return ""
        told_it = f"{self._motor} was told to turn {asked:.1f} rad in {passed:.1f} s"
        return f"{told_it} and turned {round(done, 1) + 0.0} rad by {self._encoder}"  # no -0.0

    def _begin(self, now: float, sense: float, told: float, turned: float) -> None:
        self._since, self._sense, self._told, self._turned = now, sense, told, turned
