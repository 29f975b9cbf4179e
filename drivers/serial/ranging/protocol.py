"""Benewake's frames: nine bytes, a hundred times a second, from a TFmini, TFmini-S, TFmini Plus or TF-Luna.

    59 59  distance  amplitude  temperature  sum        words of two bytes, the low one first

The distance is in centimetres, the temperature in eighths of a degree above -256 °C, the sum is the low byte of what
the other eight add up to. The first TFmini tells its mode (a number below 256) where the later ones have a temperature.

Source: Benewake's manuals SJ-PM-TFmini-T-01 A03, SJ-PM-TFmini-S A00, SJ-PM-TFmini Plus A04 (chapters 5.3, 5.4) and
SJ-PM-TF-Luna A05 (chapters 6.4, 6.8, 6.9, appendix I).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import Enum, auto

HEADER = b"YY"
SIZE = 9

_WORDS = struct.Struct("<HHH")

_FARTHEST_CM = 2000
"""The most that a manual gives as a distance."""

_COLDEST, _HOTTEST = 256, 4096
"""-224 °C, below which it is a mode, and 256 °C."""

_WEAK, _SATURATED, _DAZZLED = 0xFFFF, 0xFFFE, 0xFFFC
"""-1, -2 and -4: what a TFmini-S tells in place of a distance. The first TFmini has the -1 too; a TFmini Plus and a
TF-Luna tell 0."""

_OVEREXPOSED = 0xFFFF
_WEAKEST, _WEAKEST_OF_THE_FIRST = 100, 20
"""The amplitude below which a distance means nothing."""


class Seen(Enum):
    """What a frame says."""

    TARGET = auto()
    """Something, at the distance that is told with it; 0 is too near."""
    NOTHING = auto()
    """Too little light came back: there is nothing, or it is dark."""
    UNCLEAR = auto()
    """Too much light: something shines, or the sun."""


@dataclass(frozen=True)
class Reading:
    """A frame: its three words as they came."""

    distance_cm: int
    amplitude: int
    temperature: int

    @property
    def temperature_c(self) -> float | None:
        """The chip's temperature in °C; None from the first TFmini, which does not tell it."""
        return None if self.temperature < _COLDEST else self.temperature / 8 - 256

    @property
    def distance(self) -> float:
        """In metres; means something where a target is seen."""
        return self.distance_cm / 100

    @property
    def seen(self) -> Seen:
        """What it says, whichever of the sensors has sent it."""
        if self.amplitude == _OVEREXPOSED or self.distance_cm in {_SATURATED, _DAZZLED}:
            return Seen.UNCLEAR
        weakest = _WEAKEST_OF_THE_FIRST if self.temperature_c is None else _WEAKEST
        return Seen.NOTHING if self.distance_cm == _WEAK or self.amplitude < weakest else Seen.TARGET

    @property
    def is_possible(self) -> bool:
        """Whether a sensor would send it: what is cut out of two frames has odd words."""
        is_distance = self.distance_cm <= _FARTHEST_CM or self.distance_cm in {_WEAK, _SATURATED, _DAZZLED}
        return is_distance and self.temperature < _HOTTEST


class Parser:
    """Cuts a stream into frames.

    The header may be in a frame's words too, and one byte is a weak sum. So out of step, such as at the beginning or
    after noise, a frame is believed once another follows it without a gap: two frames after the noise it is in step
    again, and has lost none of them. In step a frame is believed at once.

    ``skipped`` is how many bytes were in no frame. It keeps less than two frames.

    >>> parser = Parser()
    >>> frame = bytes.fromhex("59 59 32 00 e8 03 c8 08 9f")
    >>> parser.feed(b"noise" + frame)
    []
    >>> [reading.distance for reading in parser.feed(frame + frame[:4])]
    [0.5, 0.5]
    """

    def __init__(self) -> None:
        self.skipped = 0
        self._rest = b""
        self._is_in_step = False

    def feed(self, data: bytes) -> list[Reading]:
        """Take a piece of the stream, cut anywhere; return what the frames that end in it say."""
        stream, at, readings = self._rest + data, 0, []
        while at + SIZE <= len(stream):
            reading = _reading(stream, at)
            if reading and not self._is_in_step:
                if at + 2 * SIZE > len(stream):
                    break
                self._is_in_step = _reading(stream, at + SIZE) is not None
            if reading and self._is_in_step:
                readings.append(reading)
                at += SIZE
            else:
                at = self._next_header(stream, at + 1)
        self._rest = stream[at:]
        return readings

    def _next_header(self, stream: bytes, at: int) -> int:
        """Go on at the next header, or where one may have begun."""
        self._is_in_step = False
        found = stream.find(HEADER, at)
        if found < 0:
            found = max(at, len(stream) - stream.endswith(HEADER[:1]))
        self.skipped += found - (at - 1)
        return found


def _reading(stream: bytes, at: int) -> Reading | None:
    """Return what the frame there says; None where there is none."""
    if not stream.startswith(HEADER, at) or sum(stream[at : at + SIZE - 1]) & 0xFF != stream[at + SIZE - 1]:
        return None
    reading = Reading(*_WORDS.unpack_from(stream, at + len(HEADER)))
    return reading if reading.is_possible else None
