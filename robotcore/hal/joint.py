"""The motion of a servo, which a simulator computes, and a run assumes of a servo without feedback."""

from __future__ import annotations

import math

from robotcore.hal.clock import Clock


class Joint:
    """An angle that moves towards its target at a constant rate.

    >>> from robotcore.hal.clock import SteppedClock
    >>> clock = SteppedClock(20.0, lambda steps: None)
    >>> joint = Joint(clock, angle=0.0, rate=2.0)
    >>> joint.turn_to(-1.0)
    >>> clock.sleep_until(0.25)
    True
    >>> joint.angle
    -0.5
    """

    def __init__(self, clock: Clock, angle: float, rate: float) -> None:
        """Create a joint at rest.

        angle: the angle at first, in radians.
        rate: the speed of the motion in rad/s.
        """
        self._clock, self._rate = clock, rate
        self._start = self._target = angle
        self._since = clock.now()

    @property
    def angle(self) -> float:
        """The present angle, in radians."""
        way = self._target - self._start
        turned = self._rate * (self._clock.now() - self._since)
        return self._target if turned >= abs(way) else self._start + math.copysign(turned, way)

    def turn_to(self, angle: float) -> None:
        """Move from the present angle towards another target, in radians."""
        self._start, self._since, self._target = self.angle, self._clock.now(), angle
