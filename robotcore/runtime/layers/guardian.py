"""The layer that renews the guardian's lease while motors turn, and counts the stops by the guardian."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from threading import RLock
from typing import TYPE_CHECKING

from robotcore.errors import GuardianError, RobotcoreError
from robotcore.hal.robot import Robot
from robotcore.runtime.layers.base import Layer, MotorOutput
from robotcore.safety.deadman import LOCK_TIMEOUT_S, MIN_LEASE_S
from robotcore.safety.guardian.protocol import GuardianReply

if TYPE_CHECKING:
    from robotcore.safety.guardian.client import Guardian


def guard_motors(raw: Robot, lease: float, end: ExitStack, priority: int | None = None) -> GuardianLayer | None:
    """Start a guardian for a robot's motors, and return its layer. None if the robot has no cutoffs.

    raw: the robot that the backend opened.
    lease: the deadman's lease, in seconds.
    end: the context that ends the guardian.
    priority: the real-time priority of the guardian, above that of the ticks; None for the normal priority.

    The guardian must stop the motors later than the deadman. So its lease is longer than the deadman's. The difference
    is the deadman's longest wait for its lock plus the longest ``extra_lease_s`` of the cutoffs.

    Raises GuardianError if the guardian does not start.
    """
    if not raw.cutoffs:
        return None
    from robotcore.safety.guardian.client import Guardian

    patience = LOCK_TIMEOUT_S + max(cutoff.extra_lease_s for cutoff in raw.cutoffs)
    return GuardianLayer(end.enter_context(Guardian(raw.cutoffs, max(lease, MIN_LEASE_S) + patience, priority)))


class GuardianLayer(Layer):
    """Begins a lease of the guardian before the first motor turns, and ends it after the last motor has stopped.

    The clock's thread may stop motors while the loop commands them. A lock makes the lease agree with the set of
    turning motors. No thread holds the lock during a driver call. If the guardian does not answer, every motor is
    stopped, and GuardianError is raised before the command.
    """

    def __init__(self, guardian: Guardian) -> None:
        self._guardian = guardian
        self._motors: list[MotorOutput] = []
        self._turning: set[object] = set()
        """The names of the turning motors, and one object for each command that is under way."""
        self._stops: list[GuardianReply] = []
        self._lock = RLock()

    def motor(self, motor: MotorOutput) -> MotorOutput:
        self._motors.append(motor)

        def set_velocity(rad_s: float) -> float:
            if not rad_s:
                motor.set_velocity(rad_s)
                self._end_turning(motor.name)
                return rad_s
            command = object()
            with self._stopping_all(), self._lock:
                if self._guardian.renew_lease():
                    self._stops += self._guardian.stops()
                self._turning.add(command)
            try:
                motor.set_velocity(rad_s)
            finally:
                with self._lock:
                    self._turning.remove(command)
                    self._turning.add(motor.name)
            return rad_s  # not the rounded velocity of some drivers, from which the acceleration limit would not rise

        def stop() -> None:
            motor.stop()
            self._end_turning(motor.name)

        return MotorOutput(motor.name, set_velocity, stop)

    def _end_turning(self, motor: str) -> None:
        with self._lock:
            if motor in self._turning:
                self._turning.remove(motor)
                if not self._turning:
                    self._guardian.end_lease()

    def take_stops(self) -> int:
        """Return the number of stops by the guardian since the last call.

        After such a stop, the motors are stopped through their drivers too. A driver does not notice the guardian's
        stop, and may send its last command again.
        """
        with self._stopping_all(), self._lock:
            stops = self._stops + self._guardian.stops()
            self._stops.clear()
        if stops:
            self._stop_all()
        return len(stops)

    @contextmanager
    def _stopping_all(self) -> Iterator[None]:
        try:
            yield
        except GuardianError:
            self._stop_all()
            raise

    def _stop_all(self) -> None:
        for motor in self._motors:
            with suppress(RobotcoreError):  # the other motors must stop too, and the next command raises again
                motor.stop()
