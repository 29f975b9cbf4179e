"""What is heard of a TFmini: it talks by itself, and nothing is ever sent to it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.serial.ports.talk import Talk
from drivers.serial.ranging.protocol import Parser, Reading, Seen
from robotcore.hardware.findings import Findings

_FULL = 4000
"""Of what nobody reads the kernel keeps little more; what comes later is dropped. Source: Linux, N_TTY_BUF_SIZE."""


class Listening(Talk):
    """Tells the findings what the newest frame says; it is ready once two frames have come in a row.

    One that has said nothing for ``silence_s`` is lost, as a board is: its last sample is read no more.

    It sends nothing, so that a port that is another board's turns nothing. Of frames that come at once only the newest
    has its distance told, for when the others came nobody knows.
    """

    def __init__(self, findings: Findings, baud: int, silence_s: float) -> None:
        self.baud, self.is_ready = baud, False
        self._findings, self._parser = findings, Parser()
        self._silence_s, self._heard_at = silence_s, -math.inf

    def begin(self, now: float) -> None:
        self.is_ready, self._parser = False, Parser()
        self._findings.unclear()

    def receive(self, data: bytes, now: float) -> None:
        if not (readings := self._parser.feed(data)):
            return
        self.is_ready, self._heard_at = True, now
        if len(data) < _FULL:
            self._judge(readings, now)

    def due(self, now: float) -> bytes:
        if self.is_ready and now - self._heard_at > self._silence_s:
            self.begin(now)
        return b""

    def unanswered(self, place: str, *, has_heard: bool = False) -> str:
        told = _NO_FRAMES if self._parser.skipped else _SILENT
        return told.format(heard=f"on {place} at {self.baud} baud", skipped=self._parser.skipped)

    def _judge(self, readings: Sequence[Reading], now: float) -> None:
        """Tell the newest; one before it that has seen something ends a row in which nothing was found."""
        *before, newest = readings
        if any(reading.seen is not Seen.NOTHING for reading in before):
            self._findings.unclear()
        match newest.seen:
            case Seen.TARGET:
                self._findings.found(newest.distance, now)
            case Seen.NOTHING:
                self._findings.nothing(now)
            case Seen.UNCLEAR:
                self._findings.unclear()


_NO_FRAMES = (
    "{skipped} bytes came {heard}, and no frame of a TFmini. Set baud to what the sensor was set to (115200 from the "
    "factory) and its output to 9 bytes in cm, and see that it is the sensor's port"
)
_SILENT = (
    "nothing comes {heard}; look at its 5 V and its ground, and whether its TX goes to the port's RX. "
    "One that was set to I2C, or to wait for a trigger, says nothing by itself"
)
