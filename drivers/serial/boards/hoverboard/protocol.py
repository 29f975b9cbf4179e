"""Frames of the Hoverboard FOC firmware: commands of 8 bytes out, feedback of 18 bytes in, all little-endian.

Source: EFeru/hoverboard-firmware-hack-FOC, `SerialCommand` in Inc/util.h, `SerialFeedback` in Src/main.c,
`usart_process_command` in Src/util.c.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import reduce
from operator import xor

START = 0xABCD
"""The first word of each frame, both ways (SERIAL_START_FRAME)."""

LIMIT = 1000
"""Steer and speed, and what the board makes of them for a wheel, are from -1000 to 1000 (INPUT_MIN, INPUT_MAX)."""

_COMMAND = struct.Struct("<HhhH")
_FEEDBACK = struct.Struct("<H6hHH")
_WORDS = struct.Struct("<9H")
_START_BYTES = START.to_bytes(2, "little")

_MOST_INPUT = 1500
"""An input is stretched to no more, by field weakening (FIELD_WEAK_HI)."""

_MOST_RPM = 2048
"""A measured speed has 12 bits and a sign: it is kept in sixteenths of an rpm, in 16 bits."""

_MOST_CENTIVOLTS = 10_000
"""No such board bears 100 V."""

_MOST_LED = 0xFF
"""What the sideboard's lamps show is a byte."""


def command(steer: int, speed: int) -> bytes:
    """Return the frame of a command; which wheel it turns how fast is the board's mixer's business.

    >>> command(0, 0).hex(" ")
    'cd ab 00 00 00 00 cd ab'
    """
    checksum = START ^ steer & 0xFFFF ^ speed & 0xFFFF
    return _COMMAND.pack(START, steer, speed, checksum)


STOP = command(0, 0)
"""Both wheels stand."""

STANDING = r"\xcd\xab\0\0\0\0"
"""The beginning of feedback from a board that has heard it."""


@dataclass(frozen=True, slots=True)
class Feedback:
    """What the board tells a hundred times a second.

    ``steer`` and ``speed`` are the newest command as it was heard: 0 where there was none for too long. The measured
    speeds are in rpm, positive as the motor turns: the right one is mounted the other way round.
    """

    steer: int
    speed: int
    right_rpm: int
    left_rpm: int
    battery_v: float
    board_c: float

    @property
    def stands(self) -> bool:
        """Whether the board has heard that both wheels are to stand, or nobody has told it that they should turn."""
        return self.steer == self.speed == 0


class Parser:
    """Finds feedback in a stream, cut anywhere, with noise in it; ``dropped`` counts frames that were none.

    A frame that is broken costs no other: what follows its start is searched again. At most a frame less one byte is
    kept.

    >>> parser = Parser()
    >>> frame = bytes.fromhex("cd ab 00 00 00 00 d8 ff 28 00 d4 0e 2c 01 00 00 c5 5b")
    >>> parser.feed(b"noise" + frame[:9]), parser.feed(frame[9:])
    ([], [Feedback(steer=0, speed=0, right_rpm=-40, left_rpm=40, battery_v=37.96, board_c=30.0)])
    """

    def __init__(self) -> None:
        self.dropped = 0
        self._kept = b""

    def feed(self, data: bytes) -> list[Feedback]:
        """Take what has come in; return what it completes."""
        stream, found, at = self._kept + data, [], 0
        while (at := _start_in(stream, at)) + _FEEDBACK.size <= len(stream):
            feedback = _feedback(stream, at)
            if feedback:
                found.append(feedback)
            else:
                self.dropped += 1
            at += _FEEDBACK.size if feedback else 1
        self._kept = stream[at:]
        return found


def _start_in(stream: bytes, at: int) -> int:
    """Return where the next frame begins, or may begin: the end, or the byte before it."""
    if (start := stream.find(_START_BYTES, at)) >= 0:
        return start
    return len(stream) - stream.endswith(_START_BYTES[:1], at)


def _feedback(stream: bytes, at: int) -> Feedback | None:
    """Return the frame at that place; None where its checksum is wrong, or no such board says so."""
    if reduce(xor, _WORDS.unpack_from(stream, at)):
        return None
    _, steer, speed, right_rpm, left_rpm, centivolts, tenths_c, led, _ = _FEEDBACK.unpack_from(stream, at)
    is_sound = (
        max(abs(steer), abs(speed)) <= _MOST_INPUT
        and max(abs(right_rpm), abs(left_rpm)) <= _MOST_RPM
        and 0 <= centivolts <= _MOST_CENTIVOLTS
        and led <= _MOST_LED
    )
    return Feedback(steer, speed, right_rpm, left_rpm, centivolts / 100, tenths_c / 10) if is_sound else None
