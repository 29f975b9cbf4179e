"""Calls the parts of the firmware that do not use Arduino. They are compiled for this computer."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterable, Sequence
from ctypes import c_bool, c_char, c_char_p, c_int16, c_int32, c_uint16, c_uint32, c_void_p
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

NOTHING, LINE, DROPPED = range(3)
"""The results of `LineReader::take` in line.h."""


class Command(NamedTuple):
    name: str
    args: tuple[int, ...]
    has_checksum: bool = False


class _ParsedLine(ctypes.Structure):
    ended: int
    isCommand: int  # noqa: N815  as in C++
    name: int
    count: int
    hasChecksum: int  # noqa: N815
    args: Sequence[int]
    _fields_: ClassVar = [
        *((name, c_int32) for name in ("ended", "isCommand", "name", "count", "hasChecksum")),
        ("args", c_int32 * 4),
    ]


_SIGNATURES: dict[str, tuple[Any, list[Any]]] = {
    "makeReader": (c_void_p, []),
    "dropReader": (None, [c_void_p]),
    "take": (_ParsedLine, [c_void_p, c_char]),
    "countEdges": (c_int32, [c_char_p, c_int32]),
    "makeDeadman": (c_void_p, [c_uint16]),
    "dropDeadman": (None, [c_void_p]),
    "feed": (None, [c_void_p, c_uint32]),
    "disarm": (None, [c_void_p]),
    "hasExpired": (c_bool, [c_void_p, c_uint32]),
    "makeController": (c_void_p, [c_int16] * 6),
    "dropController": (None, [c_void_p]),
    "setTarget": (None, [c_void_p, c_int16]),
    "step": (c_int16, [c_void_p, c_int32]),
}


class Firmware:
    """The compiled library. Each method creates a new object of the firmware."""

    def __init__(self, library: Path) -> None:
        self._c = ctypes.CDLL(str(library))
        for name, (returned, taken) in _SIGNATURES.items():
            function = getattr(self._c, name)
            function.restype, function.argtypes = returned, taken

    def parse(self, data: bytes) -> list[Command | None]:
        """Parse bytes. Return the command of each complete line, or None for a line that is no command."""
        reader = self._c.makeReader()
        try:
            lines = [self._c.take(reader, bytes([byte])) for byte in data]
        finally:
            self._c.dropReader(reader)
        return [_read_command(line) for line in lines if line.ended != NOTHING]

    def count_edges(self, levels: Iterable[int]) -> int:
        """Return the count of an encoder after a sequence of levels. Channel A is bit 1, and channel B is bit 0."""
        seen = bytes(levels)
        return int(self._c.countEdges(seen, len(seen)))

    def deadman(self, ms: int) -> Deadman:
        return Deadman(self._c, ms)

    def speed_control(self, gains: tuple[int, int, int, int], start: int = 20, full: int = 176) -> SpeedControl:
        return SpeedControl(self._c, start, full, gains)


class Deadman:
    def __init__(self, library: Any, ms: int) -> None:
        self._c, self._it = library, library.makeDeadman(ms)

    def feed(self, now: int) -> None:
        self._c.feed(self._it, now % 2**32)

    def disarm(self) -> None:
        self._c.disarm(self._it)

    def has_expired(self, now: int) -> bool:
        return bool(self._c.hasExpired(self._it, now % 2**32))

    def __del__(self) -> None:
        self._c.dropDeadman(self._it)


class SpeedControl:
    def __init__(self, library: Any, start: int, full: int, gains: tuple[int, int, int, int]) -> None:
        self._c, self._it = library, library.makeController(start, full, *gains)

    def set_target(self, speed: int) -> None:
        self._c.setTarget(self._it, speed)

    def step(self, counts: int) -> int:
        """Return the duty of the next control period from the counts of the last one."""
        return int(self._c.step(self._it, counts))

    def __del__(self) -> None:
        self._c.dropController(self._it)


def _read_command(parsed: _ParsedLine) -> Command | None:
    if not parsed.isCommand:
        return None
    return Command(chr(parsed.name), tuple(parsed.args[: parsed.count]), bool(parsed.hasChecksum))


CONTROL_PERIOD_S = 1 / 30
COUNTS = 960


@dataclass
class Motor:
    """A gear motor with a dead band and a first-order lag. Above the dead band, its speed is linear in the duty."""

    full: float
    """The speed at full duty, in counts per control period."""
    lag_s: float
    dead: float
    speed: float = 0.0
    place: float = 0.0

    def turn(self, duty: int) -> int:
        """Turn for a control period at a duty from -255 to 255. Return the encoder's new counts."""
        before = math.floor(self.place)
        goal = math.copysign(max(0.0, abs(duty) - self.dead) / (255 - self.dead) * self.full, duty)
        for _ in range(10):
            self.speed += (goal - self.speed) * (1 - math.exp(-CONTROL_PERIOD_S / 10 / self.lag_s))
            self.place += self.speed / 10
        return math.floor(self.place) - before


def run_motor(motor: Motor, step: Callable[[int], int], periods: int) -> list[float]:
    """Run a motor with a controller. Return the speed after each control period, in counts per control period.

    step: the controller. It takes the counts of the last control period, and returns the duty for the next one.
    """
    counts, speeds = 0, []
    for _ in range(periods):
        counts = motor.turn(step(counts))
        speeds.append(motor.speed)
    return speeds
