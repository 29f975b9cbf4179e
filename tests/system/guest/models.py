"""What turns on the bench: encoder discs, and wheels that motors turn."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType

from robotcore.hal.wall_clock import MonotonicClock
from tests.system.guest.chip import Chip

PHASES = ((1, 1), (0, 1), (0, 0), (1, 0))
"""Levels of the channels A and B, forward."""

SAMPLE_S = 0.007
MOST_OWED = 10.0
"""Where samples are late, a disc turns on by an edge at each: of several at once, some are not heard."""


class Disc:
    """A quadrature encoder's disc: its two lines go through the four phases, from both high, as resistors pull them."""

    def __init__(self, chip: Chip, a: int, b: int) -> None:
        self._chip, self._lines = chip, (a, b)
        self._turned = 0
        self._show()

    def turn(self, edges: int) -> int:
        """Turn on by so many edges, forward or backward; return by how many it has turned in all."""
        for _ in range(abs(edges)):
            self._turned += 1 if edges > 0 else -1
            self._show()
        return self._turned

    def _show(self) -> None:
        for line, level in zip(self._lines, PHASES[self._turned % 4], strict=True):
            self._chip.pull(line, level)


class Wheels:
    """Turns discs while the forward lines of their motors are high, by ``edges_s`` at full duty, beside a check."""

    def __init__(self, chip: Chip, discs: dict[int, Disc], edges_s: float) -> None:
        self._chip, self._discs, self._edges_s = chip, discs, edges_s
        self._clock = MonotonicClock()
        self._sampled = self._clock.now()
        self._owed = dict.fromkeys(discs, 0.0)

    def __enter__(self) -> None:
        self._work = self._clock.every(SAMPLE_S, self._sample, "wheels")

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._work.stop()

    def _sample(self) -> None:
        now = self._clock.now()
        edges, self._sampled = (now - self._sampled) * self._edges_s, now
        for forward, disc in self._discs.items():
            owed = min(self._owed[forward] + self._chip.level(forward) * edges, MOST_OWED)
            self._owed[forward] = owed - 1 if owed >= 1 else owed
            disc.turn(int(owed >= 1))


TRIGGER, ECHO = 16, 26
DELAY_US = 500
METRES_A_MICROSECOND = 343e-6 / 2


@contextmanager
def answering(chip: Chip, distance: float) -> Iterator[None]:
    """Let the module hear an echo from that far."""
    lines = [chip.file(TRIGGER, "value"), chip.file(ECHO, "pull")]
    times = [DELAY_US, round(distance / METRES_A_MICROSECOND)]
    command = [os.environ["ECHO_HELPER"], *map(str, (*lines, *times))]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout
            assert process.stdout.readline() == "ready\n"
            yield
        finally:
            process.kill()
