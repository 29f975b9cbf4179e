"""The safety stage of a motor that is not part of the drive."""

from __future__ import annotations

import math
from threading import RLock

from robotcore.hal.clock import TickClock
from robotcore.kinds.motor import invalid_velocity
from robotcore.runtime.layers.base import MotorOutput
from robotcore.safety.deadman import Deadman, TimedLock
from robotcore.safety.latch import Latch
from robotcore.safety.motor_stop import StopGroup


class StandaloneGuard:
    """Limits the commands of a motor outside the drive. Each command is sent at once, and expires after one lease.

    A velocity that is not finite trips the latch. After that, the motor stays stopped. If a tick lasts longer than a
    lease, further commands in this tick stop the motor.
    """

    def __init__(
        self,
        motor: MotorOutput,
        max_velocity: float,
        clock: TickClock,
        lease: float,
        latch: Latch,
        motor_stops: StopGroup,
    ) -> None:
        self._motor, self._max_velocity = motor, max_velocity
        self._clock, self._latch, self._motor_stops = clock, latch, motor_stops
        self._lock = RLock()
        self._deadman = Deadman(clock, lease, self._stop_after_lease, self._lock, motor_stops.reserve)
        self._stops = 0
        latch.add_stop(self.stop)

    @property
    def output(self) -> MotorOutput:
        """The output with which an app commands the motor."""
        return MotorOutput(self._motor.name, self.set_velocity, self.stop)

    def set_velocity(self, rad_s: float) -> float:
        """Send a velocity in rad/s, limited to the motor's maximum.

        Return the velocity that the motor accepted, in rad/s.
        """
        self._latch.check()
        if not math.isfinite(rad_s):
            self._latch.trip(invalid_velocity(self._motor.name, rad_s))
        if rad_s == 0:
            self.stop()
            return 0.0
        with self._lock:
            if self._clock.tick_age() >= self._deadman.lease:
                self.stop()
                return 0.0
            stops = self._stops
            self._deadman.renew(self._clock.now())
            sent = self._motor.set_velocity(max(-self._max_velocity, min(rad_s, self._max_velocity)))
            if self._stops == stops and not self._latch.error:
                return sent
        self.stop()
        return 0.0

    def stop(self) -> None:
        """Stop the motor now. If the stop hangs or fails, the deadman repeats it."""
        with TimedLock(self._lock):
            self._stop_motor()
            self._deadman.end_lease()

    def suspend(self, cause: str) -> None:
        """Stop the motor between two ticks. Only a drive records interventions, so ``cause`` is not used."""
        self.stop()

    def _stop_after_lease(self, expiry: float) -> None:
        self._stop_motor()

    def _stop_motor(self) -> None:
        self._stops += 1
        self._motor_stops.apply()
