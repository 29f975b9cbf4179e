"""The command filter of the drive. It applies the rules to each command, and sends one command in a tick."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from threading import RLock
from typing import NamedTuple, Protocol

from robotcore.errors import DeviceError, DeviceLostError, RobotcoreError
from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.devices import VelocityOutput, invalid_velocity
from robotcore.safety.deadman import Deadman, TimedLock
from robotcore.safety.latch import Latch
from robotcore.safety.motor_stop import StopGroup
from robotcore.safety.velocity_limits import STOPPED, Intervention, Rule

LOST = "lost device"
"""The cause of the interventions that stop the robot while it waits for a lost device."""


class Commit(NamedTuple):
    """The result of one tick for the drive."""

    asked: Wheels | None
    """The command of the app in rad/s; None if the app gave none."""
    sent: Wheels | None
    """The velocities that the motors accepted in rad/s; None if nothing was sent."""
    interventions: tuple[Intervention, ...]
    """The changes that the rules, the deadman and the guardian made to the command."""


class CommandFilter(Protocol):
    """The interface to which a drive sends its commands: that of the safety filter, and of a tap that wraps it."""

    @property
    def asked(self) -> Wheels: ...
    def ask(self, wheels: Wheels) -> Wheels: ...
    def stop(self) -> None: ...
    def commit(self) -> Commit: ...


class SafetyFilter:
    """Filters the commands of a drive, and sends one command a tick to its two motors.

    clock: the clock of the loop, whose time stays the same within a tick. It also measures the deadman's lease. On a
    real robot it calls the deadman in a separate thread.
    left, right: the outputs of the two motors.
    rules: the rules in the order of their use. Each rule may reduce the result of the rule before it.
    lease: the time in seconds after which a command expires.
    latch: the latch of the run. A tripped latch ends the run.
    on_sent: a function that is called with each pair of sent velocities, in rad/s, and the time in seconds.
    motor_stops: the stops of the two motors.
    take_guardian_stops: returns how many times the guardian has stopped the motors since the last call.
    """

    def __init__(
        self,
        clock: Clock,
        left: VelocityOutput,
        right: VelocityOutput,
        rules: Sequence[Rule],
        lease: float,
        latch: Latch | None = None,
        on_sent: Callable[[Wheels, float], None] | None = None,
        motor_stops: StopGroup | None = None,
        take_guardian_stops: Callable[[], int] = lambda: 0,
    ) -> None:
        self._clock = clock
        self._left, self._right = left, right
        self._rules = tuple(rules)
        self._latch = latch or Latch()
        self._on_sent = on_sent
        self._lock = RLock()
        self._motor_stops = motor_stops or StopGroup.create(left, right)
        self._deadman = Deadman(clock, lease, self._stop_after_lease, self._lock, self._motor_stops.reserve)
        self._asked: Wheels | None = None
        self._take_guardian_stops = take_guardian_stops
        self._guarded = self._sent = self._filtered_after = self._committed = STOPPED
        self._stops = self._stops_before = 0
        self._is_stopped = self._is_stopped_for_latch = False
        self._changes: list[Intervention] = []
        self._stop_interventions: list[Intervention] = []
        self._latch.add_stop(self._stop_for_latch)

    def ask(self, wheels: Wheels) -> Wheels:
        """Set the command of this tick, and return the command after the rules. Both are in rad/s.

        The command replaces an earlier one of the same tick. If a velocity is NaN or infinite, the latch trips and
        InvalidCommandError is raised. The robot then stays stopped.
        """
        self._latch.check()
        for motor, velocity in ((self._left, wheels.left), (self._right, wheels.right)):
            if not math.isfinite(velocity):
                self._latch.trip(invalid_velocity(motor.name, velocity))
        self._guarded = self._apply_rules(wheels)
        self._asked, self._is_stopped = wheels, False
        return self._guarded

    def stop(self) -> None:
        """Stop both motors now, without applying the rules. The command of this tick becomes zero.

        The lease ends after the stop. If the stop hangs or fails, the deadman tries again.
        """
        with TimedLock(self._lock):
            self._asked = self._guarded = STOPPED
            self._changes.clear()
            self._is_stopped = False
            self._stop_motors(self._clock.now())
            self._is_stopped = True
            self._deadman.end_lease()

    def suspend(self, cause: str) -> None:
        """Stop both motors between two ticks. The next tick reports an intervention with this ``cause``.

        If an exception has interrupted the tick, its command is dropped, so that the next tick does not send it.
        """
        with TimedLock(self._lock):
            now = self._clock.now()
            self._asked, self._is_stopped = None, False
            self._changes.clear()
            if self._sent != STOPPED:
                self._stop_interventions.append(Intervention(now, cause, self._sent, STOPPED))
            self._stop_motors(now)
            self._deadman.end_lease()

    @property
    def asked(self) -> Wheels:
        """The command of this tick in rad/s. If there is none yet, it is the pair of velocities that was sent last."""
        return self._asked or self._sent

    def commit(self) -> Commit:
        """Send the command of this tick and begin a new lease.

        If the tick has no command, apply the rules again to the velocities that were sent last.
        """
        guardian_stops = self._take_guardian_stops()
        self._latch.check()
        with self._lock:
            self._stops_before = self._stops
            asked, self._asked = self._asked, None
            if asked is None:
                sent = self._recheck()
            elif self._is_stopped:
                sent = STOPPED
            else:
                # The lease begins before the first motor turns, and ends after the last motor has stopped.
                wheels = self._guarded if self._sent is self._filtered_after else self._apply_rules(asked)
                if wheels != STOPPED:
                    self._deadman.renew(self._clock.now())
                sent = self._command_motors(wheels)
                if wheels == STOPPED:
                    self._deadman.end_lease()
            changes = (*self._stop_interventions, *self._changes)
            if guardian_stops:
                stop = Intervention(self._clock.now(), "guardian", self._committed, STOPPED)
                changes = (*(stop,) * guardian_stops, *changes)
            self._stop_interventions.clear()
            self._changes.clear()
            self._committed = sent or self._committed
            return Commit(asked, sent, changes)

    def _recheck(self) -> Wheels | None:
        """Apply the rules to the velocities that were sent last. If the rules reduce them, send the result.

        The lease is not renewed.
        """
        if self._sent == STOPPED or (reduced := self._apply_rules(self._sent)) == self._sent:
            return None
        return self._command_motors(reduced)

    def _command_motors(self, wheels: Wheels) -> Wheels:
        """Send velocities, and return those that the motors accepted.

        If a motor fails, or if another thread stops the motors meanwhile, stop both motors.
        """
        if not self._is_overtaken:
            motor = self._left
            try:
                left = motor.set_velocity(wheels.left)
                motor = self._right
                sent = Wheels(left, motor.set_velocity(wheels.right))
            except DeviceLostError:
                self.suspend(LOST)
                raise
            except Exception as error:
                self._stop_motors(self._clock.now())
                if isinstance(error, RobotcoreError):
                    raise
                raise DeviceError(motor.name, f"{type(error).__name__}: {error}", kind="driver-error") from error
            if not self._is_overtaken:
                self._set_sent(sent, self._clock.now())
                return sent
        self._stop_motors(self._clock.now())
        return STOPPED

    @property
    def _is_overtaken(self) -> bool:
        """Whether another thread has stopped the motors since this commit began.

        This is possible because a stop waits only a short time for the lock that a commit holds.
        """
        return self._stops != self._stops_before or self._latch.error is not None

    def _apply_rules(self, wheels: Wheels) -> Wheels:
        self._changes.clear()
        self._filtered_after = self._sent
        for rule in self._rules:
            reduced = rule(wheels, self._sent)
            if reduced != wheels:
                self._changes.append(Intervention(self._clock.now(), rule.cause, wheels, reduced))
                wheels = reduced
        return wheels

    def _stop_after_lease(self, expiry: float) -> None:
        """Stop both motors at the end of a lease."""
        driven = self._sent
        try:
            self._stop_motors(expiry)
        finally:
            if driven != STOPPED:
                self._stop_interventions.append(Intervention(expiry, "deadman", driven, STOPPED))

    def _stop_for_latch(self) -> None:
        """Stop the motors because the latch has tripped. The first call stores the interventions in the latch."""
        if not self._is_stopped_for_latch:
            self._latch.last_velocities, self._latch.unreported_interventions, self._stop_interventions = (
                self._sent,
                self._stop_interventions,
                [],
            )
            self._is_stopped_for_latch = True
        self.stop()

    def _stop_motors(self, now: float) -> None:
        """Stop both motors, even if ``on_sent`` or the other stop fails."""
        self._stops += 1
        try:
            self._set_sent(STOPPED, now)
        finally:
            self._motor_stops.apply()

    def _set_sent(self, wheels: Wheels, now: float) -> None:
        self._sent = wheels
        if self._on_sent:
            self._on_sent(wheels, now)
