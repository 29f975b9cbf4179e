"""Models of hardware on simulated lines: encoder discs, wheels, and an ultrasonic module."""

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
MAX_PENDING = 10.0
"""After a late sample, a disc turns one edge a sample for up to this many edges. Bursts of edges would be lost."""


class Disc:
    """A quadrature encoder's disc. Its two lines begin high, as if pulled up."""

    def __init__(self, chip: Chip, a: int, b: int) -> None:
        self._chip, self._lines = chip, (a, b)
        self._turned = 0
        self._show()

    def turn(self, edges: int) -> int:
        """Turn by this many edges, forward or backward; return the sum of all edges."""
        for _ in range(abs(edges)):
            self._turned += 1 if edges > 0 else -1
            self._show()
        return self._turned

    def _show(self) -> None:
        for line, level in zip(self._lines, PHASES[self._turned % 4], strict=True):
            self._chip.pull(line, level)


class Wheels:
    """Turns discs in the background while the forward lines of their motors are high.

    edges_s: edges a second at full duty.
    """

    def __init__(self, chip: Chip, discs: dict[int, Disc], edges_s: float) -> None:
        self._chip, self._discs, self._edges_s = chip, discs, edges_s
        self._clock = MonotonicClock()
        self._sampled = self._clock.now()
        self._pending = dict.fromkeys(discs, 0.0)

    def __enter__(self) -> None:
        self._work = self._clock.call_every(SAMPLE_S, self._sample, "wheels")

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._work.stop()

    def _sample(self) -> None:
        now = self._clock.now()
        edges, self._sampled = (now - self._sampled) * self._edges_s, now
        for forward, disc in self._discs.items():
            pending = min(self._pending[forward] + self._chip.level(forward) * edges, MAX_PENDING)
            self._pending[forward] = pending - 1 if pending >= 1 else pending
            disc.turn(int(pending >= 1))


TRIGGER, ECHO = 16, 26
DELAY_US = 500
METRES_A_MICROSECOND = 343e-6 / 2


@contextmanager
def echo_module(chip: Chip, distance: float) -> Iterator[None]:
    """Run an ultrasonic module during the block, with a wall at this distance in metres."""
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
