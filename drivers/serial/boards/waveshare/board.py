"""The conversation with a Waveshare board, and an odometer finer than its whole centimetres."""

from __future__ import annotations

import math
from typing import NamedTuple

from drivers.serial.boards.board import BoardProtocol
from drivers.serial.boards.devices import CountAccumulator
from drivers.serial.boards.waveshare.protocol import Feedback, Parser, Track, greeting, heartbeat, speeds
from drivers.serial.driver import Side
from robotcore.hal.devices import Voltage

PATIENCE_S = 0.1
"""By so much two lines may come in later, or closer together, than they were told."""

FASTEST_M_S = 3.0
"""No track is faster, downhill too."""


class Odometer:
    """Goes by the measured speed within the centimetre that the board tells, and never leaves that.

    So it is less than 1 cm off, and adds no error up. ``turning`` counts metres, from the first one told on.

    >>> odometer = Odometer()
    >>> for time, centimetres in ((0.0, 0), (0.05, 0), (0.1, 2)):
    ...     odometer.move(Track(centimetres, 0.1), time)
    ...     print(f"{odometer.turning.angle(1.0).angle:g} m")
    0 m
    0.005 m
    0.02 m
    """

    def __init__(self) -> None:
        self.turning = CountAccumulator()
        self._last: _Position | None = None

    def restart(self) -> None:
        """Know that the board may count from anywhere now."""
        self.turning.restart()
        self._last = None

    def is_likely(self, track: Track, time: float) -> bool:
        """Return whether it can have come so far, or a digit was lost on the line."""
        if self._last is None:
            return True
        low, high = _within(track.centimetres)
        farthest = FASTEST_M_S * (time - self._last.time + PATIENCE_S)
        return low - farthest <= self._last.metres <= high + farthest

    def move(self, track: Track, time: float) -> None:
        """Take what the board tells."""
        low, high = _within(track.centimetres)
        guess = (low + high) / 2
        if last := self._last:
            guess = last.metres + (last.speed + track.speed) / 2 * (time - last.time)
        self._last = _Position(min(max(guess, low), high), track.speed, time)
        self.turning.count(self._last.metres, time)


class _Position(NamedTuple):
    metres: float
    speed: float
    time: float


def _within(centimetres: int) -> tuple[float, float]:
    """Return between which metres those are that are cut, towards zero, to so many centimetres."""
    low = centimetres if centimetres > 0 else centimetres - 1
    high = centimetres if centimetres < 0 else centimetres + 1
    return low / 100, high / 100


SILENCE_S = 0.3
"""A board that has told nothing for so long is gone, or was reset: until then its ROM runs, and loses what is said."""

GREETING_S = 0.5
"""A board that is starting is greeted so often."""


class WaveshareProtocol(BoardProtocol):
    """Greets a board until it tells where it is; from then on tells it each new command once, and hears it.

    Each command has the board's time-out before it: a board that was reset in between stands until then, and obeys its
    time-out from then on. A board that falls silent is greeted again, and what it was told is forgotten.

    ``command`` is in m/s.
    """

    silence_s = SILENCE_S
    usual_timeout_s = 0.5
    """A board on which no motor is open stops what somebody else set turning after so long."""

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
                self._hear(feedback, now)

    def due(self, now: float) -> bytes:
        self._lose_if_silent(now)
        return self._commanded(now) if self.is_ready else self._greeted(now)

    def next_due(self, now: float) -> float:
        if not self.is_ready:
            return self._greet_at
        return min(self.command.next_due, self.command.repeat_due, self._heard_at + SILENCE_S)

    def unanswered(self, place: str, *, has_heard: bool = False) -> str:
        if not self.parser.is_older:
            return super().unanswered(place, has_heard=has_heard)
        return (
            f"the board on {place} runs ugv_base_general, which tells no odometer and drives most rovers without "
            "holding a speed. Flash Waveshare's ugv_base_ros"
        )

    def _lose(self, now: float) -> None:
        super()._lose(now)
        self._is_greeted, self._greet_at = False, now

    def _greeted(self, now: float) -> bytes:
        if now < self._greet_at:
            return b""
        self._greet_at, self._is_greeted = now + GREETING_S, True
        return greeting(self.timeout_s)

    def _commanded(self, now: float) -> bytes:
        wheels = self.command.take(now, self.timeout_s) or self.command.repeat_stop(now)
        return heartbeat(self.timeout_s) + speeds(*wheels) if wheels else b""

    def _hear(self, feedback: Feedback, now: float) -> None:
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
            self._meet()
