"""The base class of the doubles of boards, and their operation on a pty."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field

from robotcore.hal.clock import Clock, PeriodicTask
from tests.doubles.serial.pty import Pty

PERIOD_S = 0.002


class BoardDouble(ABC):
    """A double of a board, without its port. Times are in seconds on the test's clock."""

    wheels: Wheels
    """The wheels of a board with one pair of them."""

    @abstractmethod
    def receive(self, data: bytes, now: float) -> bytes:
        """Process received bytes, which may be cut at any place; return the immediate answers."""

    def live(self, now: float, seconds: float) -> bytes:
        """Advance wheels and time-outs by ``seconds`` to ``now``; return the data that the board sends periodically."""
        return b""

    def begin(self, now: float) -> None:  # noqa: B027  most boards have no state to reset
        """Reset the board. `Powered` calls this when the port is plugged in."""


class Powered:
    """Runs a board on its port, by a periodic task in simulated time and by a thread in real time."""

    def __init__(self, board: BoardDouble, pty: Pty, clock: Clock) -> None:
        self.board, self._pty, self._clock = board, pty, clock
        self._last = clock.now()
        self._was_plugged_in = False
        self._polling: PeriodicTask = clock.call_every(PERIOD_S, self._pump, "board")

    def off(self) -> None:
        """Switch the board off. May be called again."""
        self._polling.stop()

    def _pump(self) -> None:
        now = self._clock.now()
        if self._pty.is_plugged_in and not self._was_plugged_in:
            self.board.begin(now)
        self._was_plugged_in = self._pty.is_plugged_in
        received = self._pty.read_all() if self._clock.is_lockstep else self._pty.read()
        data = self.board.live(now, now - self._last) + self.board.receive(received, now)
        self._last = now
        if self._clock.is_lockstep:
            self._pty.send_all(data)
        else:
            self._pty.send(data)


LAG_S = 0.05


@dataclass
class Wheel:
    """A wheel that follows its command with a first-order lag. Units are rad and rad/s."""

    command: float = 0.0
    velocity: float = 0.0
    angle: float = 0.0

    def turn(self, seconds: float) -> None:
        """Turn the wheel for ``seconds``."""
        remaining = math.exp(-seconds / LAG_S)
        difference = self.velocity - self.command
        self.angle += self.command * seconds + difference * LAG_S * (1 - remaining)
        self.velocity = self.command + difference * remaining


@dataclass
class Wheels:
    """The left and the right wheel."""

    left: Wheel = field(default_factory=Wheel)
    right: Wheel = field(default_factory=Wheel)

    def set(self, left: float, right: float) -> None:
        self.left.command, self.right.command = left, right

    def turn(self, seconds: float) -> None:
        self.left.turn(seconds)
        self.right.turn(seconds)
