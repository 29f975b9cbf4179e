"""Lines of ASCII: what ROSArduinoBridge is asked and answers, and our firmware, which can sum them.

A question ends in CR, its answer in CR LF; nothing in an answer says what it answers. Sources: ROSArduinoBridge.ino and
commands.h of hbrobotics' ros_arduino_bridge, and `firmware/` for what ours knows besides.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import reduce
from operator import xor

LONGEST_LINE = 40
"""No answer is longer; what is, is noise, and dropped up to its end."""

REFUSED = "Invalid Command"

_PRINTABLE = re.compile(rb"[ -~]*")
_SUMMED = re.compile(r"(.*)\*([0-9A-F]{2})")


class Parser:
    """Cuts a stream into lines, whatever pieces it comes in; keeps no more than `LONGEST_LINE` bytes of it."""

    def __init__(self) -> None:
        self._kept = b""
        self._is_spoilt = False
        self.dropped = 0
        """How many lines were too long, or had bytes in them that no answer has."""

    def feed(self, data: bytes) -> list[str]:
        """Take what has come in; return the lines that it ends, without their ends."""
        *ended, rest = data.split(b"\n")
        lines = [line for piece in ended if (line := self._end(piece)) is not None]
        self._keep(rest)
        return lines

    def _end(self, piece: bytes) -> str | None:
        self._keep(piece)
        line, self._kept = self._kept.removesuffix(b"\r"), b""
        was_spoilt, self._is_spoilt = self._is_spoilt, False
        if was_spoilt or not _PRINTABLE.fullmatch(line):
            self.dropped += 1
            return None
        return line.decode("ascii")

    def _keep(self, piece: bytes) -> None:
        self._is_spoilt = self._is_spoilt or len(self._kept) + len(piece) > LONGEST_LINE
        self._kept = b"" if self._is_spoilt else self._kept + piece


@dataclass(frozen=True)
class Answer:
    """The numbers of an answer, none in an OK; or that the board did not understand."""

    numbers: tuple[int, ...] = ()
    is_refusal: bool = False


@dataclass(frozen=True)
class Question:
    """What a board is asked, and the shape by which its answer is known.

    After ``patience_s`` seconds without an answer there will be none. ``raw`` is sent in its place where it is told;
    what is answered to such a one has a shape that no other answer has, so that it ends every doubt.
    """

    text: str
    shape: re.Pattern[str]
    patience_s: float = 0.1
    raw: bytes = b""

    def frame(self, *, is_summed: bool) -> bytes:
        """Return it as it is sent."""
        return self.raw or framed(self.text, is_summed=is_summed)

    def answer(self, line: str) -> Answer | None:
        """Return what a line answers; None where it is no answer to this."""
        if line == REFUSED:
            return None if self.raw else Answer(is_refusal=True)
        if not (match := self.shape.fullmatch(line)):
            return None
        numbers = tuple(int(number) for number in match.groups() if number is not None)
        return Answer(numbers) if all(-(2**31) <= number < 2**31 for number in numbers) else None


_OK = re.compile("OK")
_LONG = r"(-?\d{1,10})"
_PAIR = re.compile(f"{_LONG} {_LONG}")
_NUMBER = re.compile(_LONG)
_NAME = r"robotcore-bridge (\d{1,4})"

COUNTS = Question("e", _PAIR)
"""The encoders' counts, left and right: 32 bits with a sign."""

RANGE = Question("z", _PAIR)
"""The newest range in mm, -1 where no echo came, and its age in ms; ours only."""

BATTERY = Question("y", _NUMBER)
"""The battery in mV, -1 where none is wired; ours only."""

PING_S = 1.0
"""The true one waits so long for an echo, and does nothing else meanwhile (Arduino's pulseIn)."""


FASTEST = 1000
"""More counts in a frame our firmware refuses; the true one would take 32767, and no such board counts as many."""


def ping(pin: int) -> Question:
    """Ask the true one for a range in cm, 0 where no echo came within `PING_S`."""
    return Question(f"p {pin}", re.compile(r"(\d{1,4}|1[0-7]\d{3})"), PING_S + 0.2)


def speeds(left: int, right: int) -> Question:
    """Tell both motors how many counts to turn in a frame of the board's, some 1/30 s."""
    return Question(f"m {left} {right}", _OK)


def duties(left: int, right: int) -> Question:
    """Tell both motors a duty from -255 to 255; ours, and builds of the true one that were given it."""
    return Question(f"o {left} {right}", _OK)


def deadman(milliseconds: int) -> Question:
    """Tell after how long without a command the motors stop by themselves: 100 to 5000; ours only."""
    return Question(f"k {milliseconds}", _OK)


STOP = speeds(0, 0)
STOP_NOW = b"\rm 0 0\r"
"""Ends what may be left of a line, and stops both motors, with sums or without."""

OBEYED = r"OK\r\n"
"""What both firmwares answer to it."""


def framed(text: str, *, is_summed: bool) -> bytes:
    r"""Return a question as it is sent.

    >>> framed("e", is_summed=True), framed("m 20 -20", is_summed=False)
    (b'e*65\r', b'm 20 -20\r')
    """
    return f"{text}*{_sum(text):02X}\r".encode() if is_summed else f"{text}\r".encode()


def checked(line: str) -> str | None:
    """Return a summed line without its sum; None where that is missing or wrong.

    >>> checked("OK*04"), checked("OK*05"), checked("OK")
    ('OK', None, None)
    """
    match = _SUMMED.fullmatch(line)
    return match[1] if match and int(match[2], 16) == _sum(match[1]) else None


def _sum(text: str) -> int:
    return reduce(xor, text.encode(), 0)


GREETING_S = 0.3
"""A board that is starting is asked so often who it is; the longest that a slow one is waited for."""


def who_is_there(baud: int) -> Question:
    """Stop the motors, and ask which firmware it is: ours answers its version, the true one the line's speed.

    ``v*76`` is a single unknown letter to the true one. Nothing else is ever answered by either.
    """
    raw = STOP_NOW + framed("v", is_summed=True) + framed("b", is_summed=False)
    return Question("v", re.compile(f"{_NAME}|({baud})"), GREETING_S, raw)


def still_there(baud: int, patience_s: float, *, is_summed: bool) -> Question:
    """Ask what nothing but the firmware that is known by now answers so, after an answer was lost."""
    shape, text = (_NAME, "v") if is_summed else (f"({baud})", "b")
    return Question(text, re.compile(shape), patience_s, b"\r" + framed(text, is_summed=is_summed))
