"""The protocol of a Waveshare board, and an odometer that is finer than the board's whole centimetres."""

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
"""The highest possible speed of a track, also downhill, in m/s. Feedback of a faster track is noise."""


class Odometer:
    """Estimates the position of a track from the board's odometer, in whole centimetres, and from the measured speed.

    The estimate is always within the centimetre that the board sends. So its error is below 1 cm, and does not grow.

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
        """The distance of the track since the first feedback, in metres."""
        self._last: _Position | None = None

    def __repr__(self) -> str:
        return f"Odometer({self.counter!r})"

    def restart(self) -> None:
        """Drop the last position after a reset of the board. The distance does not change."""
        self.counter.restart()
        self._last = None

    def is_plausible(self, track: Track, time: float) -> bool:
        """Return whether the track can have moved to this distance since the last feedback.

        track: the distance and the speed in new feedback. A wrong digit makes the distance impossible.
        time: the time of arrival of the feedback, in seconds.
        """
        if self._last is None:
            return True
        low, high = _centimetre_bounds(track.centimetres)
        farthest = FASTEST_M_S * (time - self._last.time + JITTER_S)
        return low - farthest <= self._last.metres <= high + farthest

    def move(self, track: Track, time: float) -> None:
        """Update the position by new feedback.

        track: the distance and the speed in the feedback.
        time: the time of arrival of the feedback, in seconds.
        """
        low, high = _centimetre_bounds(track.centimetres)
        guess = (low + high) / 2
        if last := self._last:
            guess = last.metres + (last.speed + track.speed) / 2 * (time - last.time)
        self._last = _Position(min(max(guess, low), high), track.speed, time)
        self.counter.add(self._last.metres, time)


class _Position(NamedTuple):
    metres: float
    speed: float
    time: float


def _centimetre_bounds(centimetres: int) -> tuple[float, float]:
    # The board rounds towards zero.
    low = centimetres if centimetres > 0 else centimetres - 1
    high = centimetres if centimetres < 0 else centimetres + 1
    return low / 100, high / 100


SILENCE_S = 0.3
"""A board that has sent nothing for this many seconds is unplugged or was reset. A board cannot receive during its
reset."""

GREETING_S = 0.5
"""The period of sending the greeting until the board sends feedback, in seconds."""


class WaveshareProtocol(BoardProtocol):
    """Sends a greeting until the board sends feedback, and then each new command once. Commands are in m/s.

    Before each command it sends the line that sets the board's time-out, because it may not detect a short reset of the
    board. If the board falls silent, the protocol drops the command and sends the greeting again.
    """

    silence_s = SILENCE_S
    default_timeout_s = 0.5
    """The time-out in seconds if no motor is open. It stops motors that another program turns."""

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
        return min(self.command.next_due, self.command.repeat_due, self._received_at + SILENCE_S)

    def explain_silence(self, place: str, *, has_received: bool = False) -> str:
        if not self.parser.is_older:
            return super().explain_silence(place, has_received=has_received)
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
        elif not all(odometer.is_plausible(feedback.track(side), now) for side, odometer in self.odometers.items()):
            self.parser.dropped += 1
            return
        for side, odometer in self.odometers.items():
            odometer.move(feedback.track(side), now)
        self.voltage = Voltage(feedback.centivolts / 100, now, self.voltage.sequence + 1 if self.voltage else 0)
        self._received_at = now
        if not self.is_ready:
            self._set_ready()
