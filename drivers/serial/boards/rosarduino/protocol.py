"""The ASCII lines of ROSArduinoBridge, and of robotcore_bridge, which adds a checksum to each line.

A request ends in CR, a reply in CR LF. A reply does not name its request.

Sources: ROSArduinoBridge.ino and commands.h of hbrobotics' ros_arduino_bridge; `firmware/` for the commands of
robotcore_bridge.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import reduce
from operator import xor

MAX_LINE_LENGTH = 40
"""The length of the longest reply in bytes. The parser drops longer lines, which are noise."""

REFUSED = "Invalid Command"

_PRINTABLE = re.compile(rb"[ -~]*")
_SUMMED = re.compile(r"(.*)\*([0-9A-F]{2})")


class Parser:
    """Splits a stream of bytes, which arrives in pieces of any length, into lines of printable ASCII."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[str]:
        """Parse received bytes; return the lines that these bytes complete, without CR LF."""
        *lines, rest = (self._rest + data).split(b"\n")
        self._rest = rest[: MAX_LINE_LENGTH + 1]  # a longer line is dropped anyway
        ended = (line.removesuffix(b"\r") for line in lines if len(line) <= MAX_LINE_LENGTH)
        return [line.decode("ascii") for line in ended if _PRINTABLE.fullmatch(line)]


@dataclass(frozen=True)
class Reply:
    """A reply from the board."""

    numbers: tuple[int, ...] = ()
    """The numbers in the reply. The reply ``OK`` has none."""
    is_refusal: bool = False
    """Whether the board rejected the request as an invalid command."""


@dataclass(frozen=True)
class Request:
    """A request to a board."""

    text: str
    """The text of the request, without checksum and CR."""
    shape: re.Pattern[str]
    """The pattern of the reply. Its groups match the numbers of the reply."""
    timeout_s: float = 0.1
    """The longest wait for the reply, in seconds."""
    raw: bytes = b""
    """The bytes of a request with a unique reply; sent in place of ``text``. Empty for all other requests.

    The board replies in the order of the requests. So no late reply to an earlier request follows a unique reply."""

    def frame(self, *, is_summed: bool) -> bytes:
        """Return the bytes of the request, with a checksum if ``is_summed``."""
        return self.raw or frame_line(self.text, is_summed=is_summed)

    def parse_reply(self, line: str) -> Reply | None:
        """Return the reply in a line; None if the line is no reply to this request."""
        if line == REFUSED:
            return None if self.raw else Reply(is_refusal=True)
        if not (match := self.shape.fullmatch(line)):
            return None
        numbers = tuple(int(number) for number in match.groups() if number is not None)
        return Reply(numbers) if all(-(2**31) <= number < 2**31 for number in numbers) else None


_OK = re.compile("OK")
_LONG = r"(-?\d{1,10})"
_PAIR = re.compile(f"{_LONG} {_LONG}")
_NUMBER = re.compile(_LONG)
_NAME = r"robotcore-bridge (\d{1,4})"

COUNTS = Request("e", _PAIR)
"""The request for the counts of the left and the right encoder, which are signed 32-bit numbers."""

RANGE = Request("z", _PAIR)
"""The request for the newest range in mm (-1 without an echo) and its age in ms. Only robotcore_bridge has it."""

BATTERY = Request("y", _NUMBER)
"""The request for the battery's voltage in mV (-1 without a battery). Only robotcore_bridge has it."""

PING_S = 1.0
"""The longest time that ROSArduinoBridge waits for an echo, in seconds. It processes no request during this time.
Source: Arduino's pulseIn."""


MAX_COUNTS_PER_PERIOD = 1000
"""The highest speed that robotcore_bridge accepts, in counts per control period.

ROSArduinoBridge accepts up to 32767, which no encoder reaches.
"""


def build_ping_request(pin: int) -> Request:
    """Return the request for the range of the module at a pin, in cm. Only ROSArduinoBridge has it.

    The range is 0 if there is no echo within `PING_S`.
    """
    return Request(f"p {pin}", re.compile(r"(\d{1,4}|1[0-7]\d{3})"), PING_S + 0.2)


def build_speed_request(left: int, right: int) -> Request:
    """Return the command that sets the speeds of both motors, in counts per control period of about 1/30 s."""
    return Request(f"m {left} {right}", _OK)


def build_duty_request(left: int, right: int) -> Request:
    """Return the command that sets the duties of both motors, from -255 to 255.

    robotcore_bridge and some builds of ROSArduinoBridge have this command.
    """
    return Request(f"o {left} {right}", _OK)


def build_deadman_request(milliseconds: int) -> Request:
    """Return the command that sets the time-out of the motors, from 100 to 5000 ms. Only robotcore_bridge has it."""
    return Request(f"k {milliseconds}", _OK)


STOP = build_speed_request(0, 0)
STOP_NOW = b"\rm 0 0\r"
"""The bytes that end a half-written line and stop both motors. Both firmwares accept them at any time, although they
have no checksum."""

STOP_CONFIRMED = r"OK\r\n"
"""The reply of both firmwares to `STOP_NOW`."""


def frame_line(text: str, *, is_summed: bool) -> bytes:
    """Return a request as bytes, with a checksum if ``is_summed``, and with CR."""
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
"""The period of requesting the firmware from a starting board, in seconds; also the longest wait for a slow reply."""


def build_identity_request(baud: int) -> Request:
    """Return the request that stops the motors and detects the firmware. Its reply is unique.

    robotcore_bridge replies with its version, and ROSArduinoBridge with its baud rate. ROSArduinoBridge rejects
    ``v*76``, the request for the version.
    """
    raw = STOP_NOW + frame_line("v", is_summed=True) + frame_line("b", is_summed=False)
    return Request("v", re.compile(f"{_NAME}|({baud})"), GREETING_S, raw)


def build_presence_request(baud: int, timeout_s: float, *, is_summed: bool) -> Request:
    """Return the request to send after a lost reply. Its reply is unique, and shows that the board is connected."""
    shape, text = (_NAME, "v") if is_summed else (f"({baud})", "b")
    return Request(text, re.compile(shape), timeout_s, b"\r" + frame_line(text, is_summed=is_summed))
