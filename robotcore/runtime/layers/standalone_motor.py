"""A motor outside the drive, as the app uses it."""

from __future__ import annotations

import math
from threading import RLock

from robotcore.geometry import to_float
from robotcore.hal.clock import TickClock
from robotcore.hal.devices import Motor, invalid_velocity
from robotcore.runtime.layers.base import MotorWrapper
from robotcore.safety import Deadman, Latch, StopGroup
from robotcore.safety.deadman import TimedLock


class StandaloneMotor(MotorWrapper):
    """A motor whose command is sent at once and lives one lease, as a drive's does: it is cut where nobody renews it.

    NaN latches, and what is latched moves no more. In a tick that lasts longer than a lease, commands are ignored.
    """

    def __init__(self, inner: Motor, clock: TickClock, lease: float, latch: Latch, brakes: StopGroup) -> None:
        super().__init__(inner)
        self._clock, self._latch, self._brakes = clock, latch, brakes
        self._lock = RLock()
        self._deadman = Deadman(clock, lease, self._cut, self._lock, brakes.reserve)
        self._halts = 0
        latch.call(self.stop)

    def set_velocity(self, rad_s: float) -> float:
        self._require_open()
        self._latch.check()
        rad_s = to_float(rad_s)
        if not math.isfinite(rad_s):
            self._latch.trip(invalid_velocity(self.name, rad_s))
        if rad_s == 0:
            self.stop()
            return 0.0
        with self._lock:
            if self._clock.tick_age() >= self._deadman.lease:
                self.stop()
                return 0.0
            halts = self._halts
            self._deadman.renew(self._clock.now())
            sent = self._inner.set_velocity(rad_s)
            if self._halts == halts and not self._latch.error:
                return sent
        self.stop()
        return 0.0

    def stop(self) -> None:
        """Stop at once. Where that hangs or fails, the deadman is the next to try."""
        if self._is_closed:
            return
        with TimedLock(self._lock):
            self._halt()
            self._deadman.rest()

    def suspend(self, cause: str) -> None:
        """Stop between two ticks; what it was for is told of drives alone."""
        self.stop()

    def _cut(self, expiry: float) -> None:
        self._halt()

    def _halt(self) -> None:
        self._halts += 1
        self._brakes.apply()

    def _apply(self, rad_s: float) -> None:
        self.set_velocity(rad_s)
