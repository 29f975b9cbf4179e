"""The command filter of the drive: holds one wheel command a tick, applies the rules, and sends it once."""

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
    """The changes that the rules, the deadman and the guardian made."""


class CommandFilter(Protocol):
    """Takes the commands of a drive: the safety filter, or a tap over it."""

    @property
    def asked(self) -> Wheels: ...
    def ask(self, wheels: Wheels) -> Wheels: ...
    def stop(self) -> None: ...
    def commit(self) -> Commit: ...


class SafetyFilter:
    """Filters the commands of a drive, and sends one command a tick to its two motors.

    clock: the clock of the loop, which stands still within a tick. The deadman's lease runs on it. On a real robot it
    calls the deadman in a thread of its own.
    left, right: the outputs of the two motors.
    rules: applied in this order. Each rule may reduce the command of the rule before it.
    lease: the time in seconds after which a command expires.
    latch: ends the run for good.
    on_sent: called with each pair of velocities that was sent, in rad/s, and the time in seconds.
    brakes: stop the two motors.
    take_guardian_stops: returns how often another process has stopped the motors since the last call.
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
        brakes: StopGroup | None = None,
        take_guardian_stops: Callable[[], int] = lambda: 0,
    ) -> None:
        self._clock = clock
        self._left, self._right = left, right
        self._rules = tuple(rules)
        self._latch = latch or Latch()
        self._on_sent = on_sent
        self._lock = RLock()
        self._brakes = brakes or StopGroup.on(left, right)
        self._deadman = Deadman(clock, lease, self._cut, self._lock, self._brakes.reserve)
        self._asked: Wheels | None = None
        self._take_guardian_stops = take_guardian_stops
        self._guarded = self._sent = self._filtered_after = self._committed = STOPPED
        self._stops = self._stops_before = 0
        self._is_stopped = self._is_cut_off = False
        self._changes: list[Intervention] = []
        self._cuts: list[Intervention] = []
        self._latch.call(self._cut_off)

    def ask(self, wheels: Wheels) -> Wheels:
        """Take a command for this tick, in place of an earlier one. Return the command after the rules, in rad/s.

        Raises InvalidCommandError if a velocity is NaN or infinite. This trips the latch, so the robot stays stopped.
        """
        self._latch.check()
        for motor, velocity in ((self._left, wheels.left), (self._right, wheels.right)):
            if not math.isfinite(velocity):
                self._latch.trip(invalid_velocity(motor.name, velocity))
        self._guarded = self._apply_rules(wheels)
        self._asked, self._is_stopped = wheels, False
        return self._guarded

    def stop(self) -> None:
        """Stop both motors now, without the rules. Zero becomes the command of this tick.

        The lease ends after the stop. If the stop hangs or fails, the deadman tries again.
        """
        with TimedLock(self._lock):
            self._asked = self._guarded = STOPPED
            self._changes.clear()
            self._is_stopped = False
            self._stop_motors(self._clock.now())
            self._is_stopped = True
            self._deadman.rest()

    def suspend(self, cause: str) -> None:
        """Stop both motors between two ticks. The next tick reports an intervention with this ``cause``.

        The command of an interrupted tick is dropped, so that the next tick does not send it.
        """
        with TimedLock(self._lock):
            now = self._clock.now()
            self._asked, self._is_stopped = None, False
            self._changes.clear()
            if self._sent != STOPPED:
                self._cuts.append(Intervention(now, cause, self._sent, STOPPED))
            self._stop_motors(now)
            self._deadman.rest()

    @property
    def asked(self) -> Wheels:
        """The command of this tick in rad/s. Without one, the velocities that were sent last."""
        return self._asked or self._sent

    def commit(self) -> Commit:
        """Send the command of this tick and begin a new lease.

        If the tick has no command, apply the rules again to the command in force.
        """
        stops = [
            Intervention(self._clock.now(), "guardian", self._committed, STOPPED)
            for _ in range(self._take_guardian_stops())
        ]
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
                    self._deadman.rest()
            changes = (*stops, *self._cuts, *self._changes)
            self._cuts.clear()
            self._changes.clear()
            self._committed = sent or self._committed
            return Commit(asked, sent, changes)

    def _recheck(self) -> Wheels | None:
        """Apply the rules to the command in force. If they reduce it, send the result; the lease goes on."""
        if self._sent == STOPPED or (reduced := self._apply_rules(self._sent)) == self._sent:
            return None
        return self._command_motors(reduced)

    def _command_motors(self, wheels: Wheels) -> Wheels:
        """Send velocities; return those that the motors accepted. If a motor fails or a stop came, stop both."""
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
                self._note(sent, self._clock.now())
                return sent
        self._stop_motors(self._clock.now())
        return STOPPED

    @property
    def _is_overtaken(self) -> bool:
        """Whether a stop came since the commit began. A stop does not wait long for the lock of a slow commit."""
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

    def _cut(self, expiry: float) -> None:
        """Stop both motors at the end of a lease."""
        driven = self._sent
        try:
            self._stop_motors(expiry)
        finally:
            if driven != STOPPED:
                self._cuts.append(Intervention(expiry, "deadman", driven, STOPPED))

    def _cut_off(self) -> None:
        """Stop for good, because the latch has tripped. A second call keeps the report of the first call."""
        if not self._is_cut_off:
            self._latch.driven, self._latch.unreported_interventions, self._cuts = self._sent, self._cuts, []
            self._is_cut_off = True
        self.stop()

    def _stop_motors(self, now: float) -> None:
        """Stop each motor independently, even if ``on_sent`` fails."""
        self._stops += 1
        try:
            self._note(STOPPED, now)
        finally:
            self._brakes.apply()

    def _note(self, wheels: Wheels, now: float) -> None:
        self._sent = wheels
        if self._on_sent:
            self._on_sent(wheels, now)
