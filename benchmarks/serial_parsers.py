"""What random bytes do to each parser of a serial line, and how many bytes it takes in a second.

    python -m benchmarks.serial_parsers

Each parser gets random bytes, random bytes of which half are such as its frames begin with, and frames without a fault,
in pieces as small as an adapter hands them over, for each of several seeds. It must not raise; the memory that it takes
at most must be no more for all the bytes than for a tenth of them; and it must take twenty times what a line at
115200 baud carries. Values that come of random bytes are counted. Exit status 1 where a bound is broken.
"""

from __future__ import annotations

import argparse
import sys
import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random
from time import perf_counter

from benchmarks.report import at_least_one, machine, print_table
from tests.doubles.serial.protocols import SPOKEN, Parser, Spoken

LINE = 11_520
"""Bytes a second at 115200 baud, 8N1."""

TIMES = 20
PIECE = 32
"""Bytes at a time; an FTDI hands over up to 62, a line's own UART some 16."""

SLACK = 4096
"""By so many bytes the memory of two measurements may differ."""


@dataclass(frozen=True)
class Measured:
    """What came of a stream: values, seconds, and the most memory that was taken, after a tenth and after all of it."""

    values: int
    seconds: float
    early_peak: int
    peak: int

    @property
    def is_flat(self) -> bool:
        return self.peak <= self.early_peak + SLACK


def main() -> int:
    """Print a line for each parser and kind of bytes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bytes", type=at_least_one, default=10**6)
    parser.add_argument("--seeds", type=at_least_one, default=3)
    asked = parser.parse_args()
    rows, are_kept = [], []
    for spoken in SPOKEN:
        for kind, stream_of in STREAMS.items():
            measured = [_measured(spoken, stream_of(spoken, Random(seed), asked.bytes)) for seed in range(asked.seeds)]
            times = asked.bytes / max(one.seconds for one in measured) / LINE
            are_kept.append(times >= TIMES and all(one.is_flat for one in measured))
            rows.append((spoken.name, kind, *_cells(measured), f"{times:.0f}"))
    print(machine())
    print_table(("parser", "bytes", "values", "most memory, tenth", "most memory, all", "× 115200 baud, least"), rows)
    print(f"{asked.seeds} seeds of {asked.bytes} bytes each; bounds: no exception, memory flat, {TIMES} × 115200 baud")
    return int(not all(are_kept))


def _cells(measured: list[Measured]) -> tuple[str, str, str]:
    values = sum(one.values for one in measured)
    early, late = (max(getattr(one, name) for one in measured) for name in ("early_peak", "peak"))
    return str(values), f"{early / 1000:.1f} kB", f"{late / 1000:.1f} kB"


def _measured(spoken: Spoken, stream: bytes) -> Measured:
    began = perf_counter()
    values = _fed(spoken.parser(), stream)
    seconds = perf_counter() - began
    return Measured(values, seconds, _peak(spoken, stream[: len(stream) // 10]), _peak(spoken, stream))


def _peak(spoken: Spoken, stream: bytes) -> int:
    """Return how many bytes were taken at most, beside the stream."""
    parser = spoken.parser()
    tracemalloc.start()
    _fed(parser, stream)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak


def _fed(parser: Parser, stream: bytes) -> int:
    return sum(len(parser.feed(stream[at : at + PIECE])) for at in range(0, len(stream), PIECE))


def _noise(_: Spoken, draw: Random, count: int) -> bytes:
    return draw.randbytes(count)


def _marks(spoken: Spoken, draw: Random, count: int) -> bytes:
    return bytes(draw.choice(spoken.marks) if draw.random() < 0.5 else draw.randrange(256) for _ in range(count))


def _frames(spoken: Spoken, draw: Random, count: int) -> bytes:
    return b"".join(_pieces(spoken, draw, count))[:count]


def _pieces(spoken: Spoken, draw: Random, count: int) -> Iterator[bytes]:
    made = 0
    while made < count:
        yield (frame := spoken.frame(draw))
        made += len(frame)


STREAMS: dict[str, Callable[[Spoken, Random, int], bytes]] = {
    "random": _noise,
    "half of them marks": _marks,
    "frames": _frames,
}

if __name__ == "__main__":
    sys.exit(main())
