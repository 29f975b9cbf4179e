"""What a recording has for one tick, handed out in its order."""

from __future__ import annotations

from collections import defaultdict, deque
from typing import TypeVar

from robotcore.errors import EmergencyStopError, Interrupted, RobotcoreError, WatchdogError
from robotcore.geometry import Wheels
from robotcore.recording import Ask, Read, Tick, Turned
from robotcore.safety.intervention import REST

CueT = TypeVar("CueT")


class Cues:
    """The asks, the reads, the angles and the standing commands of a tick. Of the last two, the last one stays."""

    def __init__(self, tick: Tick) -> None:
        self.tick = tick
        self.asks = deque(tick.asks)
        self._turned, self._standing = deque(tick.turned), deque(tick.standing)
        self.motor_asks = deque(tick.motor_asks)
        self._reads: dict[str, deque[Read]] = defaultdict(deque)
        for read in tick.reads:
            self._reads[read.device].append(read)
        self._devices = frozenset(self._reads)

    @property
    def is_cut_short(self) -> bool:
        """Whether a signal or a watchdog ended the run in this tick: what the recording lacks of it tells nothing."""
        is_signalled = self.tick.error is not None and self.tick.error.kind == Interrupted.__name__
        return is_signalled or any(each.cause == WatchdogError.cause for each in self.tick.interventions)

    @property
    def ended_before(self) -> RobotcoreError | None:
        """What was latched between two ticks, an e-stop for one; this is then the tick that did not come."""
        tick = self.tick
        has_begun = tick.reads or tick.asks or tick.motor_asks or tick.turned or not tick.interventions
        error = None if has_begun or tick.error is None else tick.error.again()
        return error if isinstance(error, RobotcoreError) and not self.is_cut_short else None

    @property
    def pressed(self) -> RobotcoreError | None:
        """The e-stop that was pressed before the end of this tick; nothing but the drive's answers tells when."""
        error = self.tick.error.again() if self.tick.error and not self.was_committed else None
        return error if isinstance(error, EmergencyStopError) else None

    @property
    def was_committed(self) -> bool:
        """Whether a command was sent at the end of this tick; an error of it has come after that."""
        return self.tick.asked is not None or self.tick.sent is not None

    def was_read(self, device: str) -> bool:
        """Return whether the recorded run read the device in this tick."""
        return device in self._devices

    def failed_others(self, device: str) -> int:
        """Return how many reads before the app's next one failed the guard or the odometry: the app heard of none."""
        left, failed = self._reads[device], 0
        while left and left[0].by and left[0].error:
            left.popleft()
            failed += 1
        if left:
            left.popleft()
        return failed

    def next_ask(self) -> Ask | None:
        """Return the next command that the recorded run gave, if there is one left."""
        return self.asks.popleft() if self.asks else None

    def next_turned(self) -> Turned | None:
        """Return the angles of the wheels; None where the recorded run had no drive."""
        return _next(self._turned)

    def next_standing(self) -> Wheels:
        """Return what was being asked of the wheels, for an app that commands one alone."""
        return _next(self._standing) or REST


def _next(left: deque[CueT]) -> CueT | None:
    if len(left) > 1:
        return left.popleft()
    return left[0] if left else None
