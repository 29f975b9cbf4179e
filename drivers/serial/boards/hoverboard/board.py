"""The protocol of a hoverboard, which sends feedback by itself and needs repeated stops."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.serial.boards.board import BoardProtocol
from drivers.serial.boards.command import WheelCommand
from drivers.serial.boards.devices import CountAccumulator
from drivers.serial.boards.hoverboard.protocol import CoefficientMixer, Feedback, Mixer, Parser, command
from robotcore.hal.devices import Voltage

PAUSE_S = 0.005
"""The pause between two commands, in seconds. The board accepts 8 bytes before a pause as a command. It ignores 16
bytes without a pause."""

SILENCE_S = 0.4
"""A board that has sent nothing for this many seconds is lost. When its motors start, a board beeps and is silent for
0.3 s."""


class HoverboardProtocol(BoardProtocol):
    """Sends the wheels' commands through the board's mixer, and integrates the measured speeds.

    A stop is repeated, because a board that receives nothing for 0.8 s beeps and reports a fault. While the board is
    silent, the angle does not change, because no speed is measured.
    """

    silence_s = SILENCE_S
    default_timeout_s = 0.8
    """SERIAL_TIMEOUT in the firmware's config.h; no command can change it."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.mixer: Mixer = CoefficientMixer()
        self.left, self.right = CountAccumulator(), CountAccumulator()
        """The turns of each motor in rpm times seconds. The sign is that of the motor, and the right motor is mounted
        the other way round."""
        self.voltage: Voltage | None = None
        self._turned = WheelCommand()
        self._parser = Parser()
        self._last: Feedback | None = None
        self._sent_at = self._free_at = -math.inf

    def begin(self, now: float) -> None:
        super().begin(now)
        self._parser, self._last = Parser(), None

    def receive(self, data: bytes, now: float) -> None:
        if heard := self._parser.feed(data):
            self._integrate(heard, now)
            self._last, self._heard_at = heard[-1], now
            if not self.is_ready:
                self._set_ready()

    def data_to_send(self, now: float) -> bytes:
        self._lose_if_silent(now)
        if not self.is_ready:
            self.command.clear()  # a silent board may still receive, and gets a stop
        if now < self._free_at:
            return b""
        wheels = self.command.take(now, self.timeout_s) or self.command.repeat_stop(now)
        return self._command_frame(wheels, now) if wheels else b""

    def next_due(self, now: float) -> float:
        return max(self._free_at, min(self.command.next_due, self.command.repeat_due))

    @property
    def is_settled(self) -> bool:
        """Whether the last command was sent and, if it is a stop, the board's feedback confirms it."""
        is_confirmed = self._last is not None and self._last.is_stopped and self._heard_at > self._sent_at
        return super().is_settled and (is_confirmed or not self.command.newest.is_stop)

    def _command_frame(self, wheels: WheelCommand, now: float) -> bytes:
        frame = command(*self.mixer.steering(*wheels))
        self._sent_at, self._free_at = now, now + PAUSE_S
        return frame

    def _integrate(self, heard: Sequence[Feedback], now: float) -> None:
        each_s = (now - self._heard_at) / len(heard)
        before = self._last
        for feedback in heard:
            if before and each_s <= SILENCE_S:
                self._turned = WheelCommand(
                    self._turned.left + (_centre_rpm(before.left_rpm) + _centre_rpm(feedback.left_rpm)) / 2 * each_s,
                    self._turned.right + (_centre_rpm(before.right_rpm) + _centre_rpm(feedback.right_rpm)) / 2 * each_s,
                )
            before = feedback
        self.left.count(self._turned.left, now)
        self.right.count(self._turned.right, now)
        self.voltage = Voltage(heard[-1].battery_v, now, self.voltage.sequence + 1 if self.voltage else 0)


def _centre_rpm(measured: int) -> float:
    """Return the mean of all speeds that the board rounds down to this whole number of rpm.

    When a robot drives forward, one side has positive speeds and the other one negative speeds. Rounding down changes
    the two amounts differently, so without this a straight drive would look like a turn.
    """
    return measured + 0.5 if measured else 0.0
