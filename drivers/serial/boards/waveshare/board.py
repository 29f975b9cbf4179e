"""The protocol of a Waveshare board, and an odometer with a finer resolution than the board's whole centimetres."""

from __future__ import annotations

import math
from typing import NamedTuple

from drivers.serial.boards.board import BoardProtocol
from drivers.serial.boards.devices import CountAccumulator
from drivers.serial.boards.waveshare.protocol import Feedback, Parser, Track, greeting, heartbeat, speeds
from drivers.serial.driver import Side
from robotcore.hal.devices import Voltage

JITTER_S = 0.1
"""The largest difference between the delays of two lines from the board, in seconds."""

FASTEST_M_S = 3.0
"""The highest possible speed of a track in m/s, also downhill."""


class Odometer:
    """Refines the board's odometer of whole centimetres by the integral of the measured speed.

    The position is always within the centimetre that the board sends, so its error is less than 1 cm and does not grow.

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
        """The distance that the track has moved since the first line from the board, in metres."""
        self._last: _Position | None = None

    def __repr__(self) -> str:
        return f"Odometer({self.counter!r})"

    def restart(self) -> None:
        """Forget the last position, because the board was reset and its odometer may have any value."""
        self.counter.restart()
        self._last = None

    def is_likely(self, track: Track, time: float) -> bool:
        """Return whether a line is plausible. If the track cannot have moved so far, a digit of the line is wrong."""
        if self._last is None:
            return True
        low, high = _centimetre_bounds(track.centimetres)
        farthest = FASTEST_M_S * (time - self._last.time + JITTER_S)
        return low - farthest <= self._last.metres <= high + farthest

    def move(self, track: Track, time: float) -> None:
        """Update the position by the distance and the speed of the track in a line.

        time: the time of arrival of the line, in seconds.
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
    """Return the smallest and the largest distance in metres that the board sends as this number of centimetres."""
    low = centimetres if centimetres > 0 else centimetres - 1
    high = centimetres if centimetres < 0 else centimetres + 1
    return low / 100, high / 100


SILENCE_S = 0.3
"""A board that has sent nothing for this many seconds is unplugged or was reset.
A reset board cannot receive during this time."""

GREETING_S = 0.5
"""The period of sending the greeting until the board answers, in seconds."""


class WaveshareProtocol(BoardProtocol):
    """Sends a greeting until the board sends feedback, and then each new command once. Commands are in m/s.

    The line that sets the board's time-out is sent before each command, because a short reset of the board may not have
    been detected. If the board falls silent, the protocol drops the command and sends the greeting again.
    """

    silence_s = SILENCE_S
    default_timeout_s = 0.5
    """The time-out in seconds if no motor is open. It stops motors that another program has turned."""

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
