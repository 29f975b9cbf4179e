"""Frames of the Hoverboard FOC firmware: commands of 8 bytes out, feedback of 18 bytes in, all little-endian.

Source: EFeru/hoverboard-firmware-hack-FOC, `SerialCommand` in Inc/util.h, `SerialFeedback` in Src/main.c,
`usart_process_command` in Src/util.c.
"""

from __future__ import annotations

import math
import struct
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import reduce
from itertools import product
from operator import xor
from typing import NamedTuple

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


ONE = 1 << 14
"""1.0 as the firmware keeps its coefficients."""


class Steering(NamedTuple):
    """The two words of a command."""

    steer: int
    speed: int


class Mixer(ABC):
    """What a board makes of steer and speed; wheels are in its own unit, from -1000 to 1000, positive forward."""

    @property
    @abstractmethod
    def straight(self) -> float:
        """The most that both wheels reach alike."""

    @property
    @abstractmethod
    def turning(self) -> float:
        """The most that the wheels reach against each other, on the spot."""

    @abstractmethod
    def steering(self, left: float, right: float) -> Steering:
        """Return the command for these wheels; of more than it can do, both have the same part: the path stays."""


class TankMixer(Mixer):
    """The board mixes nothing (TANK_STEERING): steer is the left wheel, speed the right one.

    >>> TankMixer().steering(-2000, 1000)
    Steering(steer=-1000, speed=500)
    """

    straight = turning = float(LIMIT)

    def __str__(self) -> str:
        return "tank steering"

    def steering(self, left: float, right: float) -> Steering:
        part = _part(left, right)
        return Steering(round(left * part), round(right * part))


@dataclass(frozen=True)
class CoefficientMixer(Mixer):
    """Left is speed and steer, right is speed less steer, each by its coefficient.

    They are SPEED_COEFFICIENT and STEER_COEFFICIENT in the firmware's config.h, divided by 16384. Source: `mixerFcn` in
    its Src/util.c.

    >>> CoefficientMixer().steering(101, 100), CoefficientMixer().wheels(Steering(1, 101))
    (Steering(steer=1, speed=101), (101, 100))
    >>> CoefficientMixer().steering(-1000, 1000)
    Steering(steer=-1000, speed=0)
    """

    speed_coefficient: float = 1.0
    steer_coefficient: float = 0.5

    def __str__(self) -> str:
        return f"coefficients {self.speed_coefficient:g} and {self.steer_coefficient:g}"

    @property
    def straight(self) -> float:
        return LIMIT * min(self.speed_coefficient, 1.0)

    @property
    def turning(self) -> float:
        return LIMIT * min(abs(self.steer_coefficient), 1.0)

    def steering(self, left: float, right: float) -> Steering:
        part = _part(left, right)
        steer = (left - right) * part / 2 / self.steer_coefficient
        speed = (left + right) * part / 2 / self.speed_coefficient
        part *= (again := _part(steer, speed))
        near = product(_around(steer * again), _around(speed * again))
        return min(
            (Steering(*words) for words in near), key=lambda words: self._error(words, left * part, right * part)
        )

    def wheels(self, steering: Steering) -> tuple[int, int]:
        """Return what the board makes of a command for the left and the right wheel, to the bit."""
        steer = steering.steer * 16 * round(self.steer_coefficient * ONE) >> 14
        speed = steering.speed * 16 * round(self.speed_coefficient * ONE) >> 14
        return _limited(speed + steer >> 4), _limited(speed - steer >> 4)

    def _error(self, steering: Steering, left: float, right: float) -> float:
        made_left, made_right = self.wheels(steering)
        return (made_left - left) ** 2 + (made_right - right) ** 2


def _part(*words: float) -> float:
    """Return how much of them there can be, so that none is beyond the limit."""
    return min(1.0, LIMIT / max(map(abs, (*words, 1.0))))


def _around(word: float) -> range:
    """Return the whole words next to it that a command can have, and one above: the board rounds down."""
    below = math.floor(word)
    return range(max(below, -LIMIT), min(below + 2, LIMIT) + 1)


def _limited(wheel: int) -> int:
    return max(-LIMIT, min(wheel, LIMIT))
