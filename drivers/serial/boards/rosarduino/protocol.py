"""The ASCII lines of ROSArduinoBridge, and of robotcore_bridge, which adds a checksum to each line.

A question ends in CR, an answer in CR LF. An answer does not contain the question that it belongs to. Sources:
ROSArduinoBridge.ino and
commands.h of hbrobotics' ros_arduino_bridge; `firmware/` for the commands of robotcore_bridge.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import reduce
from operator import xor

LONGEST_LINE = 40
"""The length of the longest answer in bytes. A longer line is noise, and is dropped."""

REFUSED = "Invalid Command"

_PRINTABLE = re.compile(rb"[ -~]*")
_SUMMED = re.compile(r"(.*)\*([0-9A-F]{2})")


class Parser:
    """Splits a stream of bytes, which arrives in pieces of any length, into lines.

    It stores at most `LONGEST_LINE` bytes.
    """

    def __init__(self) -> None:
        self._kept = b""
        self._is_spoilt = False
        self.dropped = 0
        """The number of dropped lines, which were too long or had bytes that no answer has."""

    def feed(self, data: bytes) -> list[str]:
        """Parse received bytes; return the lines that these bytes complete, without CR LF."""
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
    """An answer of the board."""

    numbers: tuple[int, ...] = ()
    """The numbers in the answer; the answer OK has none."""
    is_refusal: bool = False
    """Whether the board did not understand the question."""


@dataclass(frozen=True)
class Question:
    """A question to a board."""

    text: str
    """The text of the question, without checksum and CR."""
    shape: re.Pattern[str]
    """The pattern of the answer. Its groups match the numbers of the answer."""
    timeout_s: float = 0.1
    """After this many seconds, no answer to the question is expected any more."""
    raw: bytes = b""
    """Bytes to send in place of ``text``; empty for most questions. If it is set, no other question has an answer of
    this shape. So the answer shows that no late answer to an earlier question can follow."""

    def frame(self, *, is_summed: bool) -> bytes:
        """Return the bytes to send, with a checksum if ``is_summed``."""
        return self.raw or frame_line(self.text, is_summed=is_summed)

    def answer(self, line: str) -> Answer | None:
        """Return the answer that a line contains; None if the line is no answer to this question."""
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
"""The question for the counts of the left and the right encoder, which are signed 32-bit numbers."""

RANGE = Question("z", _PAIR)
"""The question for the newest range in mm, -1 without an echo, and its age in ms; robotcore_bridge only."""

BATTERY = Question("y", _NUMBER)
"""The question for the battery's voltage in mV, -1 if no battery is connected; robotcore_bridge only."""

PING_S = 1.0
"""The longest time that ROSArduinoBridge waits for an echo, in seconds. It does nothing else during this time
(Arduino's pulseIn)."""


FASTEST = 1000
"""The highest speed that robotcore_bridge accepts, in counts a frame. ROSArduinoBridge accepts 32767, more than a board
can count."""


def ping(pin: int) -> Question:
    """Return the question for a range in cm, which is 0 if there is no echo within `PING_S`; ROSArduinoBridge only."""
    return Question(f"p {pin}", re.compile(r"(\d{1,4}|1[0-7]\d{3})"), PING_S + 0.2)


def speeds(left: int, right: int) -> Question:
    """Return the command that sets the speeds of both motors, in counts a frame of about 1/30 s."""
    return Question(f"m {left} {right}", _OK)


def duties(left: int, right: int) -> Question:
    """Return the command that sets the duties of both motors, from -255 to 255.

    robotcore_bridge and some builds of ROSArduinoBridge have this command.
    """
    return Question(f"o {left} {right}", _OK)


def deadman(milliseconds: int) -> Question:
    """Return the command that sets the time-out of the motors, from 100 to 5000 ms; robotcore_bridge only."""
    return Question(f"k {milliseconds}", _OK)


STOP = speeds(0, 0)
STOP_NOW = b"\rm 0 0\r"
"""The bytes that end a half-written line and stop both motors. Both firmwares accept them, with or without
checksums."""

STOP_CONFIRMED = r"OK\r\n"
"""The answer of both firmwares to `STOP_NOW`."""


def frame_line(text: str, *, is_summed: bool) -> bytes:
    r"""Return the bytes of a question, with CR and, if ``is_summed``, a checksum.

    >>> frame_line("e", is_summed=True), frame_line("m 20 -20", is_summed=False)
    (b'e*65\r', b'm 20 -20\r')
    """
    return f"{text}*{_sum(text):02X}\r".encode() if is_summed else f"{text}\r".encode()


def remove_sum(line: str) -> str | None:
    """Return a line without its checksum; None if the checksum is missing or wrong.

    >>> remove_sum("OK*04"), remove_sum("OK*05"), remove_sum("OK")
    ('OK', None, None)
    """
    match = _SUMMED.fullmatch(line)
    return match[1] if match and int(match[2], 16) == _sum(match[1]) else None


def _sum(text: str) -> int:
    return reduce(xor, text.encode(), 0)


GREETING_S = 0.3
"""The period of asking a starting board for its firmware, and the longest wait for a slow answer, in seconds."""


def identity_question(baud: int) -> Question:
    """Return the question that stops the motors and asks which firmware the board runs.

    robotcore_bridge answers with its version, and ROSArduinoBridge with its baud rate. ROSArduinoBridge takes ``v*76``
    as one unknown letter.
    """
    raw = STOP_NOW + frame_line("v", is_summed=True) + frame_line("b", is_summed=False)
    return Question("v", re.compile(f"{_NAME}|({baud})"), GREETING_S, raw)


def presence_question(baud: int, timeout_s: float, *, is_summed: bool) -> Question:
    """Return a question whose answer no other question has, to be asked after an answer was lost."""
    shape, text = (_NAME, "v") if is_summed else (f"({baud})", "b")
    return Question(text, re.compile(shape), timeout_s, b"\r" + frame_line(text, is_summed=is_summed))
