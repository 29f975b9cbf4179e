"""The frames of Benewake's TFmini, TFmini-S, TFmini Plus and TF-Luna: nine bytes, a hundred times a second.

    59 59  distance  amplitude  temperature  sum

Distance, amplitude and temperature have two bytes, the low byte first. The distance is in centimetres, and the
temperature in eighths of a degree above -256 °C. The sum is the low byte of the sum of the other eight bytes. The
oldest model, TFmini, has no temperature. It sends its mode in this place, a number below 256.

Source: Benewake's manuals SJ-PM-TFmini-T-01 A03, SJ-PM-TFmini-S A00, SJ-PM-TFmini Plus A04 (chapters 5.3, 5.4) and
SJ-PM-TF-Luna A05 (chapters 6.4, 6.8, 6.9, appendix I).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import Enum, auto

from drivers.serial.ranging.frames import FrameParser

_WORDS = struct.Struct("<HHH")

_FARTHEST_CM = 2000
"""The longest distance in the manuals, in centimetres. A longer one is noise."""

_COLDEST, _HOTTEST = 256, 4096
"""The range of a temperature in a frame, from -224 °C to 256 °C. A lower number is the mode of a TFmini."""

_WEAK, _SATURATED, _DAZZLED = 0xFFFF, 0xFFFE, 0xFFFC
"""The codes -1, -2 and -4, which a TFmini-S sends in place of a distance. A TFmini sends only -1. A TFmini Plus and a
TF-Luna send the distance 0 instead."""

_OVEREXPOSED = 0xFFFF
_MIN_AMPLITUDE, _MIN_AMPLITUDE_TFMINI = 100, 20
"""The lowest amplitude of a valid distance, for the newer models and for the TFmini."""


class Detection(Enum):
    """The result of a measurement."""

    TARGET = auto()
    """A target at the measured distance. The distance 0 means a target nearer than the sensor's minimum."""
    NOTHING = auto()
    """Too little light came back: there is no target, or a dark target."""
    UNCLEAR = auto()
    """Too much light came back: a shining target, or the sun."""


@dataclass(frozen=True)
class Reading:
    """The content of a frame from the sensor."""

    distance_cm: int
    amplitude: int
    temperature: int
    """The temperature of the chip as in the frame; a TFmini sends its mode in this place."""

    @property
    def distance(self) -> float:
        """The distance in metres, valid only if `detection` is `Detection.TARGET`."""
        return self.distance_cm / 100

    @property
    def detection(self) -> Detection:
        """The result of the measurement, for any of the four models."""
        if self.amplitude == _OVEREXPOSED or self.distance_cm in {_SATURATED, _DAZZLED}:
            return Detection.UNCLEAR
        min_amplitude = _MIN_AMPLITUDE_TFMINI if self.temperature < _COLDEST else _MIN_AMPLITUDE
        return Detection.NOTHING if self.distance_cm == _WEAK or self.amplitude < min_amplitude else Detection.TARGET

    @property
    def is_possible(self) -> bool:
        """Whether a sensor can send this content. If not, the nine bytes are probably parts of two frames."""
        is_distance = self.distance_cm <= _FARTHEST_CM or self.distance_cm in {_WEAK, _SATURATED, _DAZZLED}
        return is_distance and self.temperature < _HOTTEST


class Parser(FrameParser[Reading]):
    """Splits a stream of bytes into frames.

    >>> parser = Parser()
    >>> frame = bytes.fromhex("59 59 32 00 e8 03 c8 08 9f")
    >>> parser.feed(b"noise" + frame)
    []
    >>> [reading.distance for reading in parser.feed(frame + frame[:4])]
    [0.5, 0.5]
    """

    header, size = b"YY", 9

    def parse(self, frame: bytes) -> Reading | None:
        if sum(frame[:-1]) & 0xFF != frame[-1]:
            return None
        reading = Reading(*_WORDS.unpack_from(frame, len(self.header)))
        return reading if reading.is_possible else None
