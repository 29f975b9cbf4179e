"""The protocol of a Waveshare board, and an odometer that is finer than the board's whole centimetres."""

from __future__ import annotations

import math

from drivers.serial.boards.board import BoardProtocol
from drivers.serial.boards.devices import CountAccumulator
from drivers.serial.boards.waveshare.protocol import Feedback, Parser, Track, greeting, heartbeat, speeds
from drivers.serial.driver import Side

JITTER_S = 0.1
"""The largest difference between the delays of two lines from the board, in seconds."""

FASTEST_M_S = 3.0
"""The highest possible speed of a track, also downhill, in m/s. Feedback of a faster track is noise."""


class Odometer(CountAccumulator):
    """The distance of a track in metres, from the board's odometer in whole centimetres and from the measured speed.

    The estimate is always within the centimetre that the board sends. So its error is below 1 cm, and does not grow.

    >>> odometer = Odometer()
    >>> for time, centimetres in ((0.0, 0), (0.05, 0), (0.1, 2)):
    ...     odometer.move(Track(centimetres, 0.1), time)
    ...     print(f"{odometer.angle(1.0).angle:g} m")
    0 m
    0.005 m
    0.02 m
    """

    _position: tuple[float, float, float] | None = None
    """The position in metres, the speed in m/s and the time of the newest feedback."""

    def restart(self) -> None:
        super().restart()
        self._position = None

    def is_plausible(self, track: Track, time: float) -> bool:
        """Return whether the track can have moved to this distance since the last feedback.

        track: the distance and the speed in new feedback. A wrong digit makes the distance impossible.
        time: the time of arrival of the feedback, in seconds.
        """
        if self._position is None:
            return True
        metres, _, last_time = self._position
        low, high = _centimetre_bounds(track.centimetres)
        farthest = FASTEST_M_S * (time - last_time + JITTER_S)
        return low - farthest <= metres <= high + farthest

    def move(self, track: Track, time: float) -> None:
        """Add the distance of new feedback, which arrived at ``time`` in seconds."""
        low, high = _centimetre_bounds(track.centimetres)
        guess = (low + high) / 2
        if self._position:
            metres, speed, last_time = self._position
            guess = metres + (speed + track.speed) / 2 * (time - last_time)
        self._position = min(max(guess, low), high), track.speed, time
        self.add(self._position[0], time)


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
        self.counters: dict[Side, Odometer] = {"left": Odometer(), "right": Odometer()}
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
        if self.is_ready:
            wheels = self.command.take(now, self.timeout_s) or self.command.repeat_stop(now)
            return heartbeat(self.timeout_s) + speeds(*wheels) if wheels else b""
        if now < self._greet_at:
            return b""
        self._greet_at, self._is_greeted = now + GREETING_S, True
        return greeting(self.timeout_s)

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

    def _take_feedback(self, feedback: Feedback, now: float) -> None:
        tracks = [(odometer, feedback.track(side)) for side, odometer in self.counters.items()]
        if not self.is_ready:
            for odometer, _ in tracks:
                odometer.restart()
        elif not all(odometer.is_plausible(track, now) for odometer, track in tracks):
            return
        for odometer, track in tracks:
            odometer.move(track, now)
        self._set_voltage(feedback.centivolts / 100, now)
        self._received_at = now
        if not self.is_ready:
            self._set_ready()
