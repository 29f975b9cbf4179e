"""The protocol of a hoverboard."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.serial.boards.board import BoardProtocol
from drivers.serial.boards.devices import CountAccumulator
from drivers.serial.boards.hoverboard.protocol import Feedback, Mixer, Parser, command
from drivers.serial.driver import Side

PAUSE_S = 0.005
"""The pause between two commands, in seconds. The board detects the end of a command by a pause. It ignores two
commands without a pause in between."""

SILENCE_S = 0.4
"""A board that has sent nothing for this many seconds is lost. A board beeps for 0.3 s when its motors start, and sends
nothing during that time."""


class HoverboardProtocol(BoardProtocol):
    """Sends the wheels' commands, converted for the board's mixer, and integrates the speeds in the feedback.

    A stop is repeated, because a board that receives nothing for 0.8 s beeps and reports an error. While the board is
    silent, the angles do not change, because there is no speed to integrate.
    """

    silence_s = SILENCE_S
    default_timeout_s = 0.8
    """SERIAL_TIMEOUT in the firmware's config.h, in seconds. No command can change it."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.mixer = Mixer()
        self.counters = {"left": CountAccumulator(), "right": CountAccumulator()}
        """The turns of each motor, in sixtieths of a turn (rpm times seconds). The right motor is mounted the other way
        round, so it counts down if the robot drives forward."""
        self._turned: dict[Side, float] = {"left": 0.0, "right": 0.0}
        self._parser = Parser()
        self._last: Feedback | None = None
        self._sent_at = self._free_at = -math.inf

    def begin(self, now: float) -> None:
        super().begin(now)
        self._parser, self._last = Parser(), None

    def receive(self, data: bytes, now: float) -> None:
        if received := self._parser.feed(data):
            self._integrate(received, now)
            self._last, self._received_at = received[-1], now
            if not self.is_ready:
                self._set_ready()

    def data_to_send(self, now: float) -> bytes:
        self._lose_if_silent(now)
        if not self.is_ready:
            self.command.clear()  # a silent board may still receive, and gets a stop
        if now < self._free_at:
            return b""
        if not (wheels := self.command.take(now, self.timeout_s) or self.command.repeat_stop(now)):
            return b""
        self._sent_at, self._free_at = now, now + PAUSE_S
        return command(*self.mixer.steering(*wheels))

    def next_due(self, now: float) -> float:
        return max(self._free_at, min(self.command.next_due, self.command.repeat_due))

    @property
    def is_settled(self) -> bool:
        """Whether the last command was sent. For a stop: whether the board's feedback confirms it too."""
        is_confirmed = self._last is not None and self._last.is_stopped and self._received_at > self._sent_at
        return super().is_settled and (is_confirmed or not self.command.newest.is_stop)

    def _integrate(self, received: Sequence[Feedback], now: float) -> None:
        each_s = (now - self._received_at) / len(received)
        before = self._last
        for feedback in received:
            if before and each_s <= SILENCE_S:
                for side in self._turned:
                    self._turned[side] += (before.centre_rpm(side) + feedback.centre_rpm(side)) / 2 * each_s
            before = feedback
        for side, counter in self.counters.items():
            counter.add(self._turned[side], now)
        self._set_voltage(received[-1].battery_v, now)
