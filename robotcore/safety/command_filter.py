"""The command filter of the drive. It applies the rules to each command, and sends one command in each tick."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from threading import RLock
from typing import NamedTuple, Protocol

from robotcore.errors import DeviceLostError
from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.drive import WheelStage
from robotcore.kinds.motor import invalid_velocity
from robotcore.safety.deadman import Deadman, TimedLock
from robotcore.safety.latch import Latch
from robotcore.safety.motor_stop import StopGroup
from robotcore.safety.velocity_limits import STOPPED, Intervention, Rule
from robotcore.safety.wheel_output import WheelOutput

ApplyRules = Callable[[Wheels], Wheels]
"""A function that returns the velocities after the rules, in rad/s."""

LOST = "lost device"
"""The cause of an intervention that stops the robot while a device is lost."""


class TickCommands(NamedTuple):
    """The commands and the interventions of one tick."""

    asked: Wheels | None
    """The app's command in rad/s. None if the app gave none."""
    sent: Wheels | None
    """The velocities that the motors accepted, in rad/s. None if nothing was sent."""
    interventions: tuple[Intervention, ...]
    """The changes of the command by the rules, the deadman and the guardian."""


class CommandFilter(WheelStage, Protocol):
    """The interface for the commands to a drive. The safety filter and the taps around it implement it."""

    def commit(self) -> TickCommands: ...


class SafetyFilter:
    """Limits the commands of a drive by rules, and sends one command in each tick to its motors.

    clock: the clock of the loop. Its time stays the same within a tick. It calls the deadman, on a real robot in a
    separate thread.
    output: sends the velocities to the motors of the drive.
    rules: the rules in their order. Each rule may reduce the result of the rule before it.
    lease: the time in seconds after which a command expires.
    latch: the latch of the run. A tripped latch ends the run.
    on_sent: a function that gets each pair of sent velocities, in rad/s, and the time in seconds.
    motor_stops: stops the motors.
    take_guardian_stops: a function that returns the number of stops by the guardian since its last call.
    wrap_rules: a function that wraps the application of the rules, for example to time it.
    """

    def __init__(
        self,
        clock: Clock,
        output: WheelOutput,
        rules: Sequence[Rule],
        lease: float,
        latch: Latch | None = None,
        on_sent: Callable[[Wheels, float], None] | None = None,
        motor_stops: StopGroup | None = None,
        take_guardian_stops: Callable[[], int] = lambda: 0,
        wrap_rules: Callable[[ApplyRules], ApplyRules] = lambda apply: apply,
    ) -> None:
        self._clock = clock
        self._output = output
        self._rules, self._apply_rules = tuple(rules), wrap_rules(self._apply_each_rule)
        self._latch = latch or Latch()
        self._on_sent = on_sent
        self._lock = RLock()
        self._motor_stops = motor_stops or StopGroup.create(*output.motors)
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

        A later command in the same tick replaces an earlier one. If a velocity is NaN or infinite, the latch trips and
        InvalidCommandError is raised. The robot then stays stopped.
        """
        self._latch.check()
        for name, velocity in zip(self._output.names, wheels, strict=True):
            if not math.isfinite(velocity):
                self._latch.trip(invalid_velocity(name, velocity))
        self._guarded = self._apply_rules(wheels)
        self._asked, self._is_stopped = wheels, False
        return self._guarded

    def stop(self) -> None:
        """Stop all motors now. The command of this tick becomes zero. No rule is applied.

        The lease ends after the stop. If the stop hangs or fails, the deadman repeats it.
        """
        with TimedLock(self._lock):
            self._asked = self._guarded = STOPPED
            self._changes.clear()
            self._is_stopped = False
            self._stop_motors(self._clock.now())
            self._is_stopped = True
            self._deadman.end_lease()

    def suspend(self, cause: str) -> None:
        """Stop all motors between two ticks. The next tick reports an intervention with this ``cause``.

        A command of an unfinished tick is dropped, so that the next tick does not send it.
        """
        with TimedLock(self._lock):
            now = self._clock.now()
            self._asked, self._is_stopped = None, False
            self._changes.clear()
            if self._sent != STOPPED:
                self._stop_interventions.append(Intervention(now, cause, self._sent, STOPPED))
            self._stop_motors(now)
            self._deadman.end_lease()

    def commit(self) -> TickCommands:
        """Send the command of this tick, and begin a new lease.

        Without a command in this tick, apply the rules to the velocities that were sent last. The lease is then not
        renewed.
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
            return TickCommands(asked, sent, changes)

    def _recheck(self) -> Wheels | None:
        if self._sent == STOPPED or (reduced := self._apply_rules(self._sent)) == self._sent:
            return None
        return self._command_motors(reduced)

    def _command_motors(self, wheels: Wheels) -> Wheels:
        # If a motor fails, or if another thread stops the motors meanwhile, all motors are stopped.
        if not self._is_overtaken:
            try:
                sent = self._output.set_wheels(wheels)
            except DeviceLostError:
                self.suspend(LOST)
                raise
            except Exception:
                self._stop_motors(self._clock.now())
                raise
            if not self._is_overtaken:
                self._set_sent(sent, self._clock.now())
                return sent
        self._stop_motors(self._clock.now())
        return STOPPED

    @property
    def _is_overtaken(self) -> bool:
        """Whether another thread has stopped the motors since this commit began.

        A stop waits only a limited time for the lock of a commit.
        """
        return self._stops != self._stops_before or self._latch.error is not None

    def _apply_each_rule(self, wheels: Wheels) -> Wheels:
        self._changes.clear()
        self._filtered_after = self._sent
        for rule in self._rules:
            reduced = rule(wheels, self._sent)
            if reduced != wheels:
                self._changes.append(Intervention(self._clock.now(), rule.cause, wheels, reduced))
                wheels = reduced
        return wheels

    def _stop_after_lease(self, expiry: float) -> None:
        driven = self._sent
        try:
            self._stop_motors(expiry)
        finally:
            if driven != STOPPED:
                self._stop_interventions.append(Intervention(expiry, "deadman", driven, STOPPED))

    def _stop_for_latch(self) -> None:
        # The first call stores the last velocities and the unreported interventions in the latch.
        if not self._is_stopped_for_latch:
            self._latch.last_velocities, self._latch.unreported_interventions, self._stop_interventions = (
                self._sent,
                self._stop_interventions,
                [],
            )
            self._is_stopped_for_latch = True
        self.stop()

    def _stop_motors(self, now: float) -> None:
        self._stops += 1
        try:
            self._set_sent(STOPPED, now)
        finally:
            self._motor_stops.apply()

    def _set_sent(self, wheels: Wheels, now: float) -> None:
        self._sent = wheels
        if self._on_sent:
            self._on_sent(wheels, now)
