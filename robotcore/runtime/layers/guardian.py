"""The layer by which a guardian hears of every command to a motor, and a run of what the guardian did."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from threading import RLock
from typing import TYPE_CHECKING

from robotcore.errors import GuardianError, RobotcoreError
from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Motor
from robotcore.hal.robot import Robot
from robotcore.runtime.layers.base import Layer, MotorWrapper
from robotcore.safety import CommandFilter, Commit, Intervention
from robotcore.safety.deadman import LOCK_TIMEOUT_S, MIN_LEASE_S
from robotcore.safety.guardian.protocol import Report
from robotcore.safety.rules import STOPPED

if TYPE_CHECKING:
    from robotcore.safety.guardian.client import Guardian


def guard_motors(raw: Robot, lease: float, end: ExitStack) -> Layer:
    """Return the layer that guards a robot's motors until ``end``. Without cutoffs the layer does nothing.

    ``lease`` is the deadman's. The guardian's is longer by the time for which the deadman waits for its lock, for it
    steps in where the deadman has not, and by the cutoffs' patience. Raises GuardianError where no guardian comes up.
    """
    if not raw.cutoffs:
        return Layer()
    from robotcore.safety.guardian.client import Guardian

    patience = LOCK_TIMEOUT_S + max(cutoff.patience_s for cutoff in raw.cutoffs)
    return GuardianLayer(end.enter_context(Guardian(raw.cutoffs, max(lease, MIN_LEASE_S) + patience)), raw.clock)


class GuardianLayer(Layer):
    """Tells the guardian that something turns: from before the first motor is told to, until the last one stands.

    A clock's thread may stop motors while the loop commands them: what is told belongs to what is known, by a lock
    that nobody holds while a driver works.
    """

    def __init__(self, guardian: Guardian, clock: Clock) -> None:
        self._guardian, self._clock = guardian, clock
        self._motors: list[Motor] = []
        self._turning: set[object] = set()
        self._stops: list[Report] = []
        self._lock = RLock()

    def motor(self, motor: Motor) -> Motor:
        self._motors.append(motor)
        return _GuardedMotor(motor, self)

    def command_filter(self, inner: CommandFilter) -> CommandFilter:
        return _GuardedFilter(inner, self, self._clock)

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

    def news(self) -> list[Report]:
        """Return the guardian's stops since the last call; the drivers are told too, for they did not hear of them."""
        with self._stopping_all(), self._lock:
            stops = self._stops + self._guardian.stops()
            self._stops.clear()
        if stops:
            self._stop_all()
        return stops

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


class _GuardedMotor(MotorWrapper):
    """A motor that the guardian knows of."""

    def __init__(self, inner: Motor, guarding: GuardianLayer) -> None:
        super().__init__(inner)
        self._guarding = guarding

    def stop(self) -> None:
        super().stop()
        self._guarding.stands(self.name)

    def _apply(self, rad_s: float) -> None:
        if rad_s:
            with self._guarding.turning(self.name):
                self._inner.set_velocity(rad_s)
        else:
            self._inner.set_velocity(rad_s)
            self._guarding.stands(self.name)


class _GuardedFilter(CommandFilter):
    """A stage whose ticks tell what the guardian did."""

    def __init__(self, inner: CommandFilter, guarding: GuardianLayer, clock: Clock) -> None:
        self._inner, self._guarding, self._clock = inner, guarding, clock
        self._sent = STOPPED

    @property
    def asked(self) -> Wheels:
        return self._inner.asked

    def ask(self, wheels: Wheels) -> Wheels:
        return self._inner.ask(wheels)

    def stop(self) -> None:
        self._inner.stop()

    def commit(self) -> Commit:
        stops = [Intervention(self._clock.now(), "guardian", self._sent, STOPPED) for _ in self._guarding.news()]
        commit = self._inner.commit()
        self._sent = commit.sent or self._sent
        return commit._replace(interventions=(*stops, *commit.interventions))
