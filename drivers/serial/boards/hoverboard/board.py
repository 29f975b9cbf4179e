"""The conversation with a hoverboard: it reports by itself, and needs commands again and again."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.serial.boards.board import BoardProtocol
from drivers.serial.boards.command import WheelCommand
from drivers.serial.boards.devices import CountAccumulator
from drivers.serial.boards.hoverboard.protocol import CoefficientMixer, Feedback, Mixer, Parser, command
from robotcore.hal.devices import Voltage

PAUSE_S = 0.005
"""Commands are this far apart: the board takes 8 bytes and a pause for one, 16 bytes for none."""

SILENCE_S = 0.4
"""A board that has told nothing for longer is lost. It is silent for 0.3 s while it beeps that its motors are on."""


class HoverboardProtocol(BoardProtocol):
    """Sends what the wheels are told, mixed as the board wants it, and adds up what it measures.

    A robot that stands is told so again and again: a board that hears nothing for 0.8 s beeps, and counts a fault.

    ``left`` and ``right`` have what each motor turned, in rpm times seconds, as the motors are mounted: the measured
    speeds over the times in which they came. While the board is silent nothing is added, for nobody measured it.
    """

    silence_s = SILENCE_S
    usual_timeout_s = 0.8
    """SERIAL_TIMEOUT in the firmware's config.h; it cannot be told otherwise."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.mixer: Mixer = CoefficientMixer()
        self.left, self.right = CountAccumulator(), CountAccumulator()
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
            self._add_up(heard, now)
            self._last, self._heard_at = heard[-1], now
            if not self.is_ready:
                self._meet()

    def due(self, now: float) -> bytes:
        self._lose_if_silent(now)
        if not self.is_ready:
            self.command.clear()  # it may hear though it tells nothing: it is told to stand
        if now < self._free_at:
            return b""
        wheels = self.command.take(now, self.timeout_s) or self.command.repeat_stop(now)
        return self._sent(wheels, now) if wheels else b""

    def next_due(self, now: float) -> float:
        return max(self._free_at, min(self.command.next_due, self.command.repeat_due))

    @property
    def is_settled(self) -> bool:
        """Whether the last command was sent and, where it was to stand, the board has told that it heard it."""
        is_heard = self._last is not None and self._last.stands and self._heard_at > self._sent_at
        return super().is_settled and (is_heard or not self.command.newest.stops)

    def _sent(self, wheels: WheelCommand, now: float) -> bytes:
        frame = command(*self.mixer.steering(*wheels))
        self._sent_at, self._free_at = now, now + PAUSE_S
        return frame

    def _add_up(self, heard: Sequence[Feedback], now: float) -> None:
        each_s = (now - self._heard_at) / len(heard)
        before = self._last
        for feedback in heard:
            if before and each_s <= SILENCE_S:
                self._turned = WheelCommand(
                    self._turned.left + (_rpm(before.left_rpm) + _rpm(feedback.left_rpm)) / 2 * each_s,
                    self._turned.right + (_rpm(before.right_rpm) + _rpm(feedback.right_rpm)) / 2 * each_s,
                )
            before = feedback
        self.left.count(self._turned.left, now)
        self.right.count(self._turned.right, now)
        self.voltage = Voltage(heard[-1].battery_v, now, self.voltage.sequence + 1 if self.voltage else 0)


def _rpm(measured: int) -> float:
    """Return the middle of the speeds for which the board tells that one.

    It rounds down, and forward is up on one side and down on the other: a robot that drives straight on would seem to
    turn.
    """
    return measured + 0.5 if measured else 0.0
