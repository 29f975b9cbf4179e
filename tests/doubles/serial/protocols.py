"""The parsers of all boards and sensors, each with a generator of random frames."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Flag, auto
from functools import reduce
from operator import xor
from random import Random
from typing import Protocol

from drivers.serial.boards.hoverboard import protocol as hoverboard
from drivers.serial.boards.rosarduino import protocol as rosarduino
from drivers.serial.boards.waveshare import protocol as waveshare
from drivers.serial.ranging import protocol as tfmini
from tests.doubles.serial.tfmini import frame


class Parser(Protocol):
    """The interface of every parser."""

    def feed(self, data: bytes) -> Sequence[object]:
        """Parse received bytes, which may be cut at any place; return the frames that they complete."""


class Damage(Flag):
    """A kind of damage to a stream."""

    NOISE = auto()
    """Noise between frames."""
    CUT = auto()
    """A frame without its start or its end."""
    CHANGED = auto()
    """A frame with one wrong byte."""


ANY = Damage.NOISE | Damage.CUT | Damage.CHANGED


@dataclass(frozen=True)
class ParserCase:
    """A parser with frames of its board."""

    name: str
    parser: Callable[[], Parser]
    frame: Callable[[Random], bytes]
    """Returns a random valid frame."""
    start_bytes: bytes
    """The bytes with which a frame may begin. In noise, they look like frames."""
    detectable: Damage
    """The damage that a checksum or the format shows. After other damage, any parser may return wrong values."""

    def __str__(self) -> str:
        return self.name


def _range(draw: Random) -> bytes:
    distance = draw.choice((draw.randrange(1200), 0x59, 0x0259, 0, 0xFFFF, 0xFFFE, 0xFFFC))
    return frame(distance, draw.choice((draw.randrange(0x10000), 0x5959)), draw.randrange(1800, 2600))


def _wheels(draw: Random) -> bytes:
    words = struct.pack(
        "<H6hH",
        hoverboard.START,
        *(draw.randint(-1000, 1000) for _ in range(4)),
        draw.randint(3000, 4200),
        draw.randint(100, 600),
        draw.randrange(256),
    )
    return words + struct.pack("<H", reduce(xor, struct.unpack("<8H", words)))


def _object(draw: Random) -> bytes:
    speeds = b'"L":%.4f,"R":%.4f' % (draw.uniform(-2, 2), draw.uniform(-2, 2))
    ways = b'"odl":%d,"odr":%d' % (draw.randint(-99999, 99999), draw.randint(-99999, 99999))
    return b'{"T":1001,%b,"gx":%d,%b,"v":%d}\r\n' % (speeds, draw.randint(-999, 999), ways, draw.randint(900, 1260))


def _line(draw: Random) -> bytes:
    return b"%d %d\r\n" % (draw.randint(-(2**31), 2**31 - 1), draw.randint(-9999, 9999))


NONE = Damage(0)
"""No damage. ROSArduinoBridge has no checksum, and two additional equal letters keep the XOR of robotcore_bridge."""

PARSER_CASES = (
    ParserCase("tfmini", tfmini.Parser, _range, b"\x59\x00\x08", ANY),
    ParserCase("hoverboard", hoverboard.Parser, _wheels, b"\xcd\xab\x00", ANY),
    ParserCase("waveshare", waveshare.Parser, _object, b'{}":,\r\n"T":1001', Damage.NOISE | Damage.CUT),
    ParserCase("ros-arduino", rosarduino.Parser, _line, b"0123456789 -*\r\n", NONE),
)
