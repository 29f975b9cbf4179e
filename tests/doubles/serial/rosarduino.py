"""Doubles of an Arduino with two wheels: with ROSArduinoBridge, and with robotcore_bridge.

Their answers were compared with those of the firmwares on a simulated AVR, byte for byte.
"""

from __future__ import annotations

import math
import re
from abc import abstractmethod
from functools import reduce
from operator import xor

from tests.doubles.serial.board import BoardDouble, Wheels

REFUSED = "Invalid Command"
STOPS = {"m 0 0", "o 0 0"}
"""The commands that robotcore_bridge always executes, even without a checksum."""

FULL_SPEED_RAD_S = 16.0
"""The velocity of a wheel at full duty."""


class ArduinoDouble(BoardDouble):
    """The base class of both doubles. ``counts_per_turn`` counts edges."""

    control_period_s: float

    def __init__(self, counts_per_turn: int = 960, *, takes_duties: bool = True) -> None:
        self.wheels = Wheels()
        self.counts_per_turn, self.takes_duties = counts_per_turn, takes_duties
        self.commands: list[str] = []
        """All executed lines, without checksums."""
        self.now = 0.0
        self.begin(0.0)

    def begin(self, now: float) -> None:
        """Reset the board. The wheels stop, and counts start at zero."""
        self.wheels.set(0, 0)
        self.deadman_s, self._fed = 2.0, -math.inf
        self._zeros = self._read_angles()
        self._line = b""
        self.now = now

    def receive(self, data: bytes, now: float) -> bytes:
        self.now = now
        *lines, self._line = (self._line + data).split(b"\r")
        return b"".join(self._obey(line.decode("latin-1")) for line in lines)

    def live(self, now: float, seconds: float) -> bytes:
        if now - self._fed > self.deadman_s:
            self.wheels.set(0, 0)
        self.wheels.turn(seconds)
        return b""

    @property
    def _counts(self) -> str:
        counts = (now - zero for now, zero in zip(self._read_angles(), self._zeros, strict=True))
        return " ".join(str(count) for count in counts)

    @abstractmethod
    def _obey(self, line: str) -> bytes:
        """Execute a line, and return the reply."""

    def _drive(self, letter: str, left: int, right: int) -> str:
        self._fed = self.now
        unit = FULL_SPEED_RAD_S / 255 if letter == "o" else math.tau / self.counts_per_turn / self.control_period_s
        self.wheels.set(left * unit, right * unit)
        return "OK"

    def _record(self, line: str, answer: str) -> str:
        if answer != REFUSED:
            self.commands.append(line)
        return answer

    def _read_angles(self) -> tuple[int, int]:
        edge = math.tau / self.counts_per_turn
        return math.floor(self.wheels.left.angle / edge + 1e-9), math.floor(self.wheels.right.angle / edge + 1e-9)


class RosArduinoBridgeDouble(ArduinoDouble):
    """A board with ROSArduinoBridge, which executes each line as a command, and rejects an empty line."""

    control_period_s = 0.033
    has_wheels = True

    def _obey(self, line: str) -> bytes:
        letter, arguments = _read(line)
        return f"{self._record(line, self._answer(letter, *arguments))}\r\n".encode()

    def _answer(self, letter: str, first: int, second: int) -> str:
        if letter == "b":
            return "57600"
        if letter == "p":
            return "50"
        if letter == "e" and self.has_wheels:
            return self._counts
        if self.has_wheels and (letter == "m" or (letter == "o" and self.takes_duties)):
            return self._drive(letter, first, second)
        return REFUSED


def _read(line: str) -> tuple[str, tuple[int, int]]:
    """Parse a line like the firmware: the last letter before a space, and two numbers like C's atoi."""
    words = line.split(" ")
    texts = [*words[1:2], "".join(words[2:]), ""]
    numbers = [int(match[0]) if (match := re.match(r"[-+]?\d+", text)) else 0 for text in texts]
    return words[0][-1:], (numbers[0], numbers[1])


class RobotcoreBridgeDouble(ArduinoDouble):
    """A board with robotcore_bridge, which refuses malformed lines. Its reply has a checksum if the request has one."""

    control_period_s = 1 / 30
    version = 1

    def __init__(self, *, millivolts: int = 7400, counts_per_turn: int = 960) -> None:
        self.millivolts = millivolts
        super().__init__(counts_per_turn=counts_per_turn)

    def begin(self, now: float) -> None:
        super().begin(now)
        self._needs_checksums = False
        self._measured = now

    def live(self, now: float, seconds: float) -> bytes:
        if now - self._measured >= 0.06:
            self._measured = now
        return super().live(now, seconds)

    def _obey(self, line: str) -> bytes:
        line = line.removeprefix("\n")
        if not line:
            return b""
        text, star, checksum = line.partition("*")
        is_summed = bool(star)
        is_right = is_summed and checksum == f"{_sum(text):02X}"
        self._needs_checksums = is_right or (self._needs_checksums and line != "v")
        is_trusted = is_right or not (is_summed or (self._needs_checksums and line[0] in "mokur")) or line in STOPS
        answer = self._record(text, self._answer(text) if is_trusted and len(line) < 32 else REFUSED)
        return f"{answer}*{_sum(answer):02X}\r\n".encode() if is_summed else f"{answer}\r\n".encode()

    def _answer(self, text: str) -> str:
        if not re.fullmatch(r"[a-z]( -?\d{1,6})*", text):
            return REFUSED
        letter, *numbers = text.split(" ")
        arguments = [int(number) for number in numbers]
        most = {"m": 1000, "o": 255}.get(letter)
        if most and len(arguments) == 2 and all(abs(number) <= most for number in arguments):
            return self._drive(letter, *arguments)
        if letter == "k" and len(arguments) == 1 and 100 <= arguments[0] <= 5000:
            self.deadman_s = arguments[0] / 1000
            return "OK"
        answers = {
            "b": "57600",
            "e": self._counts,
            "v": f"robotcore-bridge {self.version}",
            "y": str(self.millivolts),
            "z": f"500 {min(65535, round((self.now - self._measured) * 1000))}",
        }
        return REFUSED if arguments else answers.get(letter, REFUSED)


def _sum(text: str) -> int:
    return reduce(xor, text.encode("latin-1"), 0)
