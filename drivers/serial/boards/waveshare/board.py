"""The protocol of a Waveshare board, and an odometer finer than its whole centimetres."""

from __future__ import annotations

import math
from typing import NamedTuple

from drivers.serial.boards.board import BoardProtocol
from drivers.serial.boards.devices import CountAccumulator
from drivers.serial.boards.waveshare.protocol import Feedback, Parser, Track, greeting, heartbeat, speeds
from drivers.serial.driver import Side
from robotcore.hal.devices import Voltage

JITTER_S = 0.1
"""The variation of the time between the sending of a line and its arrival."""

FASTEST_M_S = 3.0
"""No track is faster, also downhill."""


class Odometer:
    """Integrates the measured speed within the centimetre that the board sends.

    So its error is less than 1 cm, and does not grow.

    >>> odometer = Odometer()
    >>> for time, centimetres in ((0.0, 0), (0.05, 0), (0.1, 2)):
    ...     odometer.move(Track(centimetres, 0.1), time)
    ...     print(f"{odometer.counter.angle(1.0).angle:g} m")
    0 m
    0.005 m
    0.02 m
    """

    def __init__(self) -> None:
        self.counter = CountAccumulator()
        """The way of the track in metres, from the first line on."""
        self._last: _Position | None = None

    def __repr__(self) -> str:
        return f"Odometer({self.counter!r})"

    def restart(self) -> None:
        """Drop the last position: the board was reset, and its count may have any value."""
        self.counter.restart()
        self._last = None

    def is_likely(self, track: Track, time: float) -> bool:
        """Return whether the track can have moved so far; if not, the line has a wrong digit."""
        if self._last is None:
            return True
        low, high = _centimetre_bounds(track.centimetres)
        farthest = FASTEST_M_S * (time - self._last.time + JITTER_S)
        return low - farthest <= self._last.metres <= high + farthest

    def move(self, track: Track, time: float) -> None:
        """Take the way and the speed of the track from a line.

        time: when the line arrived, in seconds.
        """
        low, high = _centimetre_bounds(track.centimetres)
        guess = (low + high) / 2
        if last := self._last:
            guess = last.metres + (last.speed + track.speed) / 2 * (time - last.time)
        self._last = _Position(min(max(guess, low), high), track.speed, time)
        self.counter.count(self._last.metres, time)


class _Position(NamedTuple):
    metres: float
    speed: float
    time: float


def _centimetre_bounds(centimetres: int) -> tuple[float, float]:
    """Return the lowest and the highest way in metres that the board cuts, towards zero, to these centimetres."""
    low = centimetres if centimetres > 0 else centimetres - 1
    high = centimetres if centimetres < 0 else centimetres + 1
    return low / 100, high / 100


SILENCE_S = 0.3
"""A board that has sent nothing for so long is unplugged or was reset. Until then its ROM runs, and drops data."""

GREETING_S = 0.5
"""The period of sending the greeting until the board answers."""


class WaveshareProtocol(BoardProtocol):
    """Sends a greeting until the board sends feedback, and then each new command once. Commands are in m/s.

    The board's time-out precedes each command. So a board that was reset unnoticed has its time-out before it turns. A
    board that falls silent gets the greeting again, and its command is dropped.
    """

    silence_s = SILENCE_S
    default_timeout_s = 0.5
    """If no motor is open, this time-out stops motors that another program turns."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.odometers: dict[Side, Odometer] = {"left": Odometer(), "right": Odometer()}
        self.voltage: Voltage | None = None
        self.parser = Parser()
        self._is_greeted = False
        self._greet_at = -math.inf

    def begin(self, now: float) -> None:
        self.parser.restart()
        super().begin(now)

    def receive(self, data: bytes, now: float) -> None:
        for feedback in self.parser.feed(data):
            if self._is_greeted:
                self._take_feedback(feedback, now)

    def data_to_send(self, now: float) -> bytes:
        self._lose_if_silent(now)
        return self._command_lines(now) if self.is_ready else self._greeting(now)

    def next_due(self, now: float) -> float:
        if not self.is_ready:
            return self._greet_at
        return min(self.command.next_due, self.command.repeat_due, self._heard_at + SILENCE_S)

    def explain_silence(self, place: str, *, has_heard: bool = False) -> str:
        if not self.parser.is_older:
            return super().explain_silence(place, has_heard=has_heard)
        return (
            f"the board on {place} runs ugv_base_general, which has no odometer and does not control the speed of most "
            "rovers. Flash Waveshare's ugv_base_ros"
        )

    def _lose(self, now: float) -> None:
        super()._lose(now)
        self._is_greeted, self._greet_at = False, now

    def _greeting(self, now: float) -> bytes:
        if now < self._greet_at:
            return b""
        self._greet_at, self._is_greeted = now + GREETING_S, True
        return greeting(self.timeout_s)

    def _command_lines(self, now: float) -> bytes:
        wheels = self.command.take(now, self.timeout_s) or self.command.repeat_stop(now)
        return heartbeat(self.timeout_s) + speeds(*wheels) if wheels else b""

    def _take_feedback(self, feedback: Feedback, now: float) -> None:
        if not self.is_ready:
            for odometer in self.odometers.values():
                odometer.restart()
        elif not all(odometer.is_likely(feedback.track(side), now) for side, odometer in self.odometers.items()):
            self.parser.dropped += 1
            return
        for side, odometer in self.odometers.items():
            odometer.move(feedback.track(side), now)
        self.voltage = Voltage(feedback.centivolts / 100, now, self.voltage.sequence + 1 if self.voltage else 0)
        self._heard_at = now
        if not self.is_ready:
            self._set_ready()
