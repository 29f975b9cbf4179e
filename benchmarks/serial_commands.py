"""Measure how old commands are when they arrive over a serial line, and whether the line is overloaded.

    python -m benchmarks.serial_commands

Numbered commands of each board's size are set 200 times a second, for a line of that board's speed. A pty carries them,
and its far end computes the time that the bytes would take on the wire. The age of a command is from its setting until
its last byte has left. For comparison, the table has the age of the last command if each were written at once. On a
busy machine the far end may read late, and then gets several commands at once. The exit status is 1 if a command waits
longer than this delay explains, or arrives after a newer one.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from statistics import median, quantiles

from benchmarks.report import machine, print_table
from drivers.serial.line import Line
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.serial.line import BITS_PER_BYTE, NumberingProtocol, ReceivedFrame, Wire
from tests.doubles.serial.pty import Pty

EVERY_S = 0.005
LISTENING_S = 0.0005
TIMES = ("age, median", "99 %", "most", "waited, most", "far end late, most", "age if all were sent")


@dataclass(frozen=True)
class BoardLine:
    """A board: the speed of its line, and the size in bytes of a command for both motors."""

    name: str
    baud: int
    size: int

    @property
    def frame_s(self) -> float:
        return self.size * BITS_PER_BYTE / self.baud


BOARDS = (
    BoardLine("sabertooth", 9600, 8),
    BoardLine("ros-arduino, summed", 57600, 12),
    BoardLine("waveshare", 115200, 52),
    BoardLine("hoverboard", 115200, 8),
    BoardLine("waveshare, were it slower", 9600, 52),
)


@dataclass(frozen=True)
class LineResult:
    """The result of a line: the times of sent commands, the received frames, and the longest delay of a read."""

    sent: list[float]
    received: list[ReceivedFrame]
    latest_s: float

    @property
    def ages(self) -> list[float]:
        return [received.left_at - self.sent[received.number] for received in self.received]

    @property
    def is_in_order(self) -> bool:
        numbers = [received.number for received in self.received]
        return numbers == sorted(set(numbers))

    @property
    def waited_s(self) -> float:
        return max(received.waited for received in self.received)


class Listener:
    """The far end of the pty. It passes bytes to a simulated wire, and stores the longest time between two reads."""

    def __init__(self, pty: Pty, wire: Wire, clock: MonotonicClock) -> None:
        self._pty, self._wire, self._clock = pty, wire, clock
        self._last = clock.now()
        self.latest_s = 0.0

    def listen(self) -> None:
        received, now = self._pty.read(), self._clock.now()
        self.latest_s, self._last = max(self.latest_s, now - self._last), now
        self._wire.receive(received, now)


def main() -> int:
    """Print a line for each board."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=10.0)
    options = parser.parse_args()
    outcomes = [(board, _drive(board, options.seconds)) for board in BOARDS]
    print(machine())
    print_table(
        ("line", "set", "sent", "share of the line", *TIMES),
        [_build_row(board, outcome, options.seconds) for board, outcome in outcomes],
    )
    print(f"set every {EVERY_S * 1000:g} ms for {options.seconds:g} s; times in ms")
    return int(not all(_is_kept(board, outcome) for board, outcome in outcomes))


def _is_kept(board: BoardLine, outcome: LineResult) -> bool:
    return outcome.is_in_order and outcome.waited_s <= outcome.latest_s + board.frame_s


def _build_row(board: BoardLine, outcome: LineResult, seconds: float) -> tuple[str, ...]:
    ages = outcome.ages
    carried = len(outcome.received) * board.frame_s / seconds
    piled_up = max(0.0, len(outcome.sent) * board.frame_s - seconds) + board.frame_s
    late = quantiles(ages, n=100, method="inclusive")[-1]
    times = (median(ages), late, max(ages), outcome.waited_s, outcome.latest_s, piled_up)
    name = f"{board.name}: {board.size} bytes at {board.baud}"
    return (
        name,
        str(len(outcome.sent)),
        str(len(outcome.received)),
        f"{carried:.0%}",
        *(f"{t * 1000:.1f}" for t in times),
    )


def _drive(board: BoardLine, seconds: float) -> LineResult:
    clock, sent = MonotonicClock(), []
    wire, protocol = Wire(board.baud, board.size), NumberingProtocol(board.baud, board.size)
    with tempfile.TemporaryDirectory() as folder, Pty(Path(folder)) as pty:
        listener = Listener(pty, wire, clock)
        listening = clock.every(LISTENING_S, listener.listen, "far end")
        line = Line(str(pty.path), protocol, clock)
        line.open("wheel", 1.0)
        begin = clock.now()
        while clock.now() < begin + seconds:
            sent.append(clock.now())
            protocol.set(len(sent) - 1, sent[-1])
            line.wake()
            clock.sleep_until(sent[-1] + EVERY_S)
        line.close()
        listening.stop()
    clock.close()
    return LineResult(sent, wire.received, listener.latest_s)


if __name__ == "__main__":
    sys.exit(main())
