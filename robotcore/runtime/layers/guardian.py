"""The layer by which a guardian hears of every command to a motor, and a run of what the guardian did."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from threading import RLock
from typing import TYPE_CHECKING

from robotcore.errors import GuardianError, RobotcoreError
from robotcore.hal.robot import Robot
from robotcore.runtime.layers.base import Layer, MotorOutput
from robotcore.safety.deadman import LOCK_TIMEOUT_S, MIN_LEASE_S
from robotcore.safety.guardian.protocol import Report

if TYPE_CHECKING:
    from robotcore.safety.guardian.client import Guardian


def guard_motors(raw: Robot, lease: float, end: ExitStack) -> GuardianLayer | None:
    """Return the layer that guards a robot's motors until ``end``; None if the robot has no cutoffs.

    ``lease`` is the deadman's. The guardian's is longer by the time for which the deadman waits for its lock, for it
    steps in where the deadman has not, and by the cutoffs' patience. Raises GuardianError where no guardian comes up.
    """
    if not raw.cutoffs:
        return None
    from robotcore.safety.guardian.client import Guardian

    patience = LOCK_TIMEOUT_S + max(cutoff.patience_s for cutoff in raw.cutoffs)
    return GuardianLayer(end.enter_context(Guardian(raw.cutoffs, max(lease, MIN_LEASE_S) + patience)))


class GuardianLayer(Layer):
    """Tells the guardian that something turns: from before the first motor is told to, until the last one stands.

    A clock's thread may stop motors while the loop commands them: what is told belongs to what is known, by a lock
    that nobody holds while a driver works.
    """

    def __init__(self, guardian: Guardian) -> None:
        self._guardian = guardian
        self._motors: list[MotorOutput] = []
        self._turning: set[object] = set()
        self._stops: list[Report] = []
        self._lock = RLock()

    def motor(self, motor: MotorOutput) -> MotorOutput:
        self._motors.append(motor)

        def set_velocity(rad_s: float) -> float:
            if rad_s:
                with self.turning(motor.name):
                    return motor.set_velocity(rad_s)
            sent = motor.set_velocity(rad_s)
            self.stands(motor.name)
            return sent

        def stop() -> None:
            motor.stop()
            self.stands(motor.name)

        return MotorOutput(motor.name, set_velocity, stop)

    @contextmanager
    def turning(self, motor: str) -> Iterator[None]:
        """Guard the command that makes a motor turn, and the motor from then on.

        Raises GuardianError before the command where nobody would guard it; every motor is then stopped.
        """
        command = object()
        with self._stopping_all(), self._lock:
            if self._guardian.renew_lease():
                self._stops += self._guardian.stops()
            self._turning.add(command)
        try:
            yield
        finally:
            with self._lock:
                self._turning.remove(command)
                self._turning.add(motor)

    def stands(self, motor: str) -> None:
        """Guard a motor no longer: it was told to stand."""
        with self._lock:
            if motor in self._turning:
                self._turning.remove(motor)
                if not self._turning:
                    self._guardian.end_lease()

    def take_stops(self) -> int:
        """Return how often the guardian has stopped the motors since the last call.

        If it has, stop the drivers' motors too: the drivers still hold the old command.
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
            with suppress(RobotcoreError):  # one that fails keeps no other from stopping; its next command tells
                motor.stop()
