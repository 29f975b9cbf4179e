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
"""The first word of each frame in both directions (SERIAL_START_FRAME)."""

LIMIT = 1000
"""Steer, speed and the value of a wheel are from -1000 to 1000 (INPUT_MIN, INPUT_MAX)."""

_COMMAND = struct.Struct("<HhhH")
_FEEDBACK = struct.Struct("<H6hHH")
_WORDS = struct.Struct("<9H")
_START_BYTES = START.to_bytes(2, "little")

_MAX_INPUT = 1500
"""The largest input with field weakening (FIELD_WEAK_HI)."""

_MAX_RPM = 2048
"""The firmware stores a speed in sixteenths of an rpm in 16 bits, so it has 12 bits and a sign."""

_MAX_CENTIVOLTS = 10_000
"""No such board withstands 100 V."""

_MAX_LED = 0xFF
"""The state of the sideboard's lamps is a byte."""


def command(steer: int, speed: int) -> bytes:
    """Return the frame of a command; the board's mixer makes wheel values of it.

    >>> command(0, 0).hex(" ")
    'cd ab 00 00 00 00 cd ab'
    """
    checksum = START ^ steer & 0xFFFF ^ speed & 0xFFFF
    return _COMMAND.pack(START, steer, speed, checksum)


STOP = command(0, 0)
"""The frame that stops both wheels."""

STANDING = r"\xcd\xab\0\0\0\0"
"""A regular expression for the begin of feedback from a board that has received the stop."""


@dataclass(frozen=True, slots=True)
class Feedback:
    """A frame that the board sends a hundred times a second."""

    steer: int
    """The steer of the newest command that the board received; 0 after its time-out."""
    speed: int
    """The speed of that command."""
    right_rpm: int
    """The measured speed, positive as the motor is mounted: the right motor is mounted the other way round."""
    left_rpm: int
    battery_v: float
    board_c: float
    """The temperature of the board in °C."""

    @property
    def is_stopped(self) -> bool:
        """Whether the newest command in the board is a stop, or its time-out has dropped the command."""
        return self.steer == self.speed == 0


class Parser:
    """Finds feedback in a stream that is cut anywhere and has noise.

    After a broken frame the search goes on behind its first byte, so that no other frame is lost. The parser keeps at
    most one byte less than a frame.

    >>> parser = Parser()
    >>> frame = bytes.fromhex("cd ab 00 00 00 00 d8 ff 28 00 d4 0e 2c 01 00 00 c5 5b")
    >>> parser.feed(b"noise" + frame[:9]), parser.feed(frame[9:])
    ([], [Feedback(steer=0, speed=0, right_rpm=-40, left_rpm=40, battery_v=37.96, board_c=30.0)])
    """

    def __init__(self) -> None:
        self.dropped = 0
        """The number of starts without a valid frame."""
        self._rest = b""

    def feed(self, data: bytes) -> list[Feedback]:
        """Take received bytes; return the frames that they complete."""
        stream, found, at = self._rest + data, [], 0
        while (at := _find_start(stream, at)) + _FEEDBACK.size <= len(stream):
            feedback = _parse_feedback(stream, at)
            if feedback:
                found.append(feedback)
            else:
                self.dropped += 1
            at += _FEEDBACK.size if feedback else 1
        self._rest = stream[at:]
        return found


def _find_start(stream: bytes, at: int) -> int:
    """Return the index of the next start, or of the end, or of a last byte that may begin a start."""
    if (start := stream.find(_START_BYTES, at)) >= 0:
        return start
    return len(stream) - stream.endswith(_START_BYTES[:1], at)


def _parse_feedback(stream: bytes, at: int) -> Feedback | None:
    """Return the frame at an index; None if its checksum is wrong or a value is impossible."""
    if reduce(xor, _WORDS.unpack_from(stream, at)):
        return None
    _, steer, speed, right_rpm, left_rpm, centivolts, tenths_c, led, _ = _FEEDBACK.unpack_from(stream, at)
    is_sound = (
        max(abs(steer), abs(speed)) <= _MAX_INPUT
        and max(abs(right_rpm), abs(left_rpm)) <= _MAX_RPM
        and 0 <= centivolts <= _MAX_CENTIVOLTS
        and led <= _MAX_LED
    )
    return Feedback(steer, speed, right_rpm, left_rpm, centivolts / 100, tenths_c / 10) if is_sound else None


ONE = 1 << 14
"""The fixed-point value of 1.0 for the firmware's coefficients."""


class Steering(NamedTuple):
    """The two words of a command, each from -1000 to 1000."""

    steer: int
    speed: int


class Mixer(ABC):
    """The board's mixer of steer and speed. Wheel values are from -1000 to 1000, positive forward."""

    @property
    @abstractmethod
    def straight(self) -> float:
        """The largest value of both wheels on a straight path."""

    @property
    @abstractmethod
    def turning(self) -> float:
        """The largest value of the wheels against each other, on the spot."""

    @abstractmethod
    def steering(self, left: float, right: float) -> Steering:
        """Return the command for two wheel values; too large values are scaled together, so that the path stays."""


class TankMixer(Mixer):
    """No mixing (TANK_STEERING): steer is the left wheel, speed the right one.

    >>> TankMixer().steering(-2000, 1000)
    Steering(steer=-1000, speed=500)
    """

    straight = turning = float(LIMIT)

    def __str__(self) -> str:
        return "tank steering"

    def steering(self, left: float, right: float) -> Steering:
        scale = _scale(left, right)
        return Steering(round(left * scale), round(right * scale))


@dataclass(frozen=True)
class CoefficientMixer(Mixer):
    """Left is speed plus steer, right is speed minus steer, each times its coefficient.

    Source: `mixerFcn` in the firmware's Src/util.c.

    >>> CoefficientMixer().steering(101, 100), CoefficientMixer().wheels(Steering(1, 101))
    (Steering(steer=1, speed=101), (101, 100))
    >>> CoefficientMixer().steering(-1000, 1000)
    Steering(steer=-1000, speed=0)
    """

    speed_coefficient: float = 1.0
    """SPEED_COEFFICIENT in the firmware's config.h, divided by 16384."""
    steer_coefficient: float = 0.5
    """STEER_COEFFICIENT, divided by 16384."""

    def __str__(self) -> str:
        return f"coefficients {self.speed_coefficient:g} and {self.steer_coefficient:g}"

    @property
    def straight(self) -> float:
        return LIMIT * min(self.speed_coefficient, 1.0)

    @property
    def turning(self) -> float:
        return LIMIT * min(abs(self.steer_coefficient), 1.0)

    def steering(self, left: float, right: float) -> Steering:
        scale = _scale(left, right)
        steer = (left - right) * scale / 2 / self.steer_coefficient
        speed = (left + right) * scale / 2 / self.speed_coefficient
        scale *= (again := _scale(steer, speed))
        near = product(_neighbours(steer * again), _neighbours(speed * again))
        return min(
            (Steering(*words) for words in near), key=lambda words: self._error(words, left * scale, right * scale)
        )

    def wheels(self, steering: Steering) -> tuple[int, int]:
        """Return the left and the right wheel value of a command, equal to the firmware's to the bit."""
        steer = steering.steer * 16 * round(self.steer_coefficient * ONE) >> 14
        speed = steering.speed * 16 * round(self.speed_coefficient * ONE) >> 14
        return _clamp(speed + steer >> 4), _clamp(speed - steer >> 4)

    def _error(self, steering: Steering, left: float, right: float) -> float:
        made_left, made_right = self.wheels(steering)
        return (made_left - left) ** 2 + (made_right - right) ** 2


def _scale(*words: float) -> float:
    """Return the factor, 1 at most, by which no word is beyond the limit."""
    return min(1.0, LIMIT / max(map(abs, (*words, 1.0))))


def _neighbours(word: float) -> range:
    """Return the words of a command next to a value; the board rounds down, so the second one is above it."""
    below = math.floor(word)
    return range(max(below, -LIMIT), min(below + 2, LIMIT) + 1)


def _clamp(wheel: int) -> int:
    return max(-LIMIT, min(wheel, LIMIT))
