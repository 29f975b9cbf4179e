"""The command filter of the drive: holds one wheel command a tick, applies the rules, and sends it once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from threading import RLock
from typing import NamedTuple, Protocol

from robotcore.errors import DeviceLostError
from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.devices import VelocityOutput, invalid_velocity
from robotcore.safety.deadman import Deadman, TimedLock
from robotcore.safety.latch import Latch
from robotcore.safety.motor_stop import StopGroup
from robotcore.safety.rules import STOPPED, Intervention, Rule

LOST = "lost device"
"""Why the robot stands, as interventions name it, while it waits for a device."""


class Commit(NamedTuple):
    """What a tick asked for and what was sent; None where it asked for nothing."""

    asked: Wheels | None
    sent: Wheels | None
    interventions: tuple[Intervention, ...]


class CommandFilter(Protocol):
    """What the commands of a drive pass: the safety stage, or a layer over it."""

    @property
    def asked(self) -> Wheels: ...
    def ask(self, wheels: Wheels) -> Wheels: ...
    def stop(self) -> None: ...
    def commit(self) -> Commit: ...


class SafetyFilter:
    """Guards the two motors of a drive.

    ``clock`` is the loop's, which stands still within a tick; the deadman's lease runs on it too, and a clock may cut
    from a thread of its own. ``latch`` ends the run for good. ``on_sent`` hears of each velocity that the wheels are
    told, and when. ``brakes`` are those on the two motors. ``take_guardian_stops`` returns how often another process
    has stopped the motors since the last call.
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
        """Take a command for this tick, instead of an earlier one; return what will be sent.

        Raises InvalidCommandError where a velocity is NaN or infinite; from then on nothing moves any more.
        """
        self._latch.check()
        for motor, velocity in ((self._left, wheels.left), (self._right, wheels.right)):
            if not math.isfinite(velocity):
                self._latch.trip(invalid_velocity(motor.name, velocity))
        self._guarded = self._apply_rules(wheels)
        self._asked, self._is_stopped = wheels, False
        return self._guarded

    def stop(self) -> None:
        """Stop both motors now, past every rule; zero is then this tick's command.

        The lease ends when they were stopped: where a stop hangs or fails, the deadman is the next to try.
        """
        with TimedLock(self._lock):
            self._asked = self._guarded = STOPPED
            self._changes.clear()
            self._is_stopped = False
            self._stop_motors(self._clock.now())
            self._is_stopped = True
            self._deadman.rest()

    def suspend(self, cause: str) -> None:
        """Stop both motors between two ticks: it is no command, so the next tick tells it as an intervention.

        What a tick that was broken off had asked for is forgotten: the next one would send it, and nobody asked then.
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
        """The command as this tick has it: its own, or what was last sent."""
        return self._asked or self._sent

    def commit(self) -> Commit:
        """Send this tick's command and begin a new lease; without one, guard again what is still being driven."""
        stops = [
            Intervention(self._clock.now(), "guardian", self._committed, STOPPED)
            for _ in range(self._take_guardian_stops())
        ]
        self._latch.check()
        with self._lock:
            self._stops_before = self._stops
            asked, self._asked = self._asked, None
            sent = self._recheck() if asked is None else self._send(asked)
            changes = (*stops, *self._cuts, *self._changes)
            self._cuts.clear()
            self._changes.clear()
            self._committed = sent or self._committed
            return Commit(asked, sent, changes)

    def _recheck(self) -> Wheels | None:
        """Lessen a command that lives on where the rules would no longer let it pass; its lease goes on."""
        if self._sent == STOPPED or (lessened := self._apply_rules(self._sent)) == self._sent:
            return None
        return self._command_motors(lessened)

    def _send(self, asked: Wheels) -> Wheels:
        """Send a command. Its lease begins before the first motor turns, and ends after the last one has stopped.

        A stop of this tick was sent already. The rules are applied again if the motors were stopped since.
        """
        if self._is_stopped:
            return STOPPED
        wheels = self._guarded if self._sent is self._filtered_after else self._apply_rules(asked)
        if wheels != STOPPED:
            self._deadman.renew(self._clock.now())
        sent = self._command_motors(wheels)
        if wheels == STOPPED:
            self._deadman.rest()
        return sent

    def _command_motors(self, wheels: Wheels) -> Wheels:
        """Tell the motors, and return what they say they do; where one fails, or a stop came meanwhile, stop both."""
        if not self._is_overtaken:
            try:
                sent = Wheels(self._left.set_velocity(wheels.left), self._right.set_velocity(wheels.right))
            except DeviceLostError:
                self.suspend(LOST)
                raise
            except Exception:
                self._stop_motors(self._clock.now())
                raise
            if not self._is_overtaken:
                self._note(sent, self._clock.now())
                return sent
        self._stop_motors(self._clock.now())
        return STOPPED

    @property
    def _is_overtaken(self) -> bool:
        """Whether a stop came since the commit began: past its lock, where the rules or a motor took their time."""
        return self._stops != self._stops_before or self._latch.error is not None

    def _apply_rules(self, wheels: Wheels) -> Wheels:
        self._changes.clear()
        self._filtered_after = self._sent
        for rule in self._rules:
            lessened = rule(wheels, self._sent)
            if lessened != wheels:
                self._changes.append(Intervention(self._clock.now(), rule.cause, wheels, lessened))
                wheels = lessened
        return wheels

    def _cut(self, expiry: float) -> None:
        """Stop both motors; where a stop had failed, once more."""
        driven = self._sent
        try:
            self._stop_motors(expiry)
        finally:
            if driven != STOPPED:
                self._cuts.append(Intervention(expiry, "deadman", driven, STOPPED))

    def _cut_off(self) -> None:
        """Stop for good: the latch has tripped. A second try reports what the first one found."""
        if not self._is_cut_off:
            self._latch.driven, self._latch.unreported_interventions, self._cuts = self._sent, self._cuts, []
            self._is_cut_off = True
        self.stop()

    def _stop_motors(self, now: float) -> None:
        """Stop each motor on its own, also if noting it fails."""
        self._stops += 1
        try:
            self._note(STOPPED, now)
        finally:
            self._brakes.apply()

    def _note(self, wheels: Wheels, now: float) -> None:
        self._sent = wheels
        if self._on_sent:
            self._on_sent(wheels, now)
