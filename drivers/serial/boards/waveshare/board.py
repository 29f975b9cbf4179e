"""What is said to a Waveshare UGV board, and heard."""

from __future__ import annotations

import math

from drivers.serial.boards.command import Command, Told
from drivers.serial.boards.settings import Side
from drivers.serial.boards.waveshare.odometer import Odometer
from drivers.serial.boards.waveshare.protocol import Feedback, Parser, greeting, heartbeat, speeds
from drivers.serial.ports.talk import Talk
from robotcore.devices import Voltage

TIMEOUT_S = 0.5
"""A board on which no motor is open stops what somebody else set turning after so long."""

SILENT_S = 0.3
"""A board that has told nothing for so long is gone, or was reset: until then its ROM runs, and loses what is said."""

GREETING_S = 0.5
"""A board that is starting is greeted so often."""

STOPPED_S = 0.25
"""A board that is to stand is told so this often, for a line may be lost."""


class WaveshareTalk(Talk):
    """Greets a board until it tells where it is; from then on tells it each new command once, and hears it.

    Each command has the board's time-out before it: a board that was reset in between stands until then, and obeys its
    time-out from then on. A board that falls silent is greeted again, and what it was told is forgotten.

    ``command`` is in m/s.
    """

    def __init__(self, baud: int) -> None:
        self.baud = baud
        self.is_ready = False
        self.command = Command()
        self.odometers: dict[Side, Odometer] = {"left": Odometer(), "right": Odometer()}
        self.voltage: Voltage | None = None
        self.parser = Parser()
        self._timeouts_s: list[float] = []
        self._is_greeted = False
        self._heard_at = self._greet_at = self._stop_at = -math.inf

    @property
    def timeout_s(self) -> float:
        """How long after the last command the board stops its motors by itself."""
        return min(self._timeouts_s, default=TIMEOUT_S)

    @property
    def stops_itself(self) -> str:
        return f"The board stops its motors {self.timeout_s:g} s after the last command that it heard"

    @property
    def is_settled(self) -> bool:
        """Whether the newest command has been sent; the board does not acknowledge it."""
        return math.isinf(self.command.next_due)

    def limit(self, timeout_s: float) -> None:
        """Have the board stop by itself after so long; the shortest time counts that any motor asks for."""
        self._timeouts_s.append(timeout_s)

    def begin(self, now: float) -> None:
        self.parser.restart()
        self._lose(now)

    def receive(self, data: bytes, now: float) -> None:
        for feedback in self.parser.feed(data):
            if self._is_greeted:
                self._hear(feedback, now)

    def due(self, now: float) -> bytes:
        if self.is_ready and now - self._heard_at > SILENT_S:
            self._lose(now)
        return self._commanded(now) if self.is_ready else self._greeted(now)

    def next_due(self, now: float) -> float:
        if not self.is_ready:
            return self._greet_at
        again = self._stop_at if self.command.told.stops else math.inf
        return min(self.command.next_due, again, self._heard_at + SILENT_S)

    def unanswered(self, place: str) -> str:
        if not self.parser.is_older:
            return super().unanswered(place)
        return (
            f"the board on {place} runs ugv_base_general, which tells no odometer and drives most rovers without "
            "holding a speed. Flash Waveshare's ugv_base_ros"
        )

    def _lose(self, now: float) -> None:
        self.is_ready = self._is_greeted = False
        self._greet_at = now

    def _greeted(self, now: float) -> bytes:
        if now < self._greet_at:
            return b""
        self._greet_at, self._is_greeted = now + GREETING_S, True
        return greeting(self.timeout_s)

    def _commanded(self, now: float) -> bytes:
        told = self.command.take(now)
        if told is None and (now < self._stop_at or not self.command.told.stops):
            return b""
        self._stop_at = now + STOPPED_S
        return heartbeat(self.timeout_s) + speeds(*(told or Told()))

    def _hear(self, feedback: Feedback, now: float) -> None:
        if not self.is_ready:
            self.command.forget()
            for odometer in self.odometers.values():
                odometer.restart()
        elif not all(odometer.is_likely(feedback.track(side), now) for side, odometer in self.odometers.items()):
            self.parser.dropped += 1
            return
        for side, odometer in self.odometers.items():
            odometer.move(feedback.track(side), now)
        self.voltage = Voltage(feedback.centivolts / 100, now, self.voltage.sequence + 1 if self.voltage else 0)
        self._heard_at = now
        self.is_ready = True
