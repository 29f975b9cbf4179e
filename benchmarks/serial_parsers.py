"""Feed random bytes to each parser of a serial line, and measure its speed and memory.

    python -m benchmarks.serial_parsers

Each parser gets random bytes, random bytes of which half are start bytes of its frames, and valid frames. They come in
pieces as small as those of an adapter, for each of several seeds. A parser must not raise. Its memory for all bytes
must not exceed that for a tenth of them. It must be twenty times as fast as a line at 115200 baud. Values from random
bytes are counted. The exit status is 1 if a bound is broken.
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
from tests.doubles.serial.protocols import PARSER_CASES, Parser, ParserCase

LINE = 11_520
"""The bytes per second of a line at 115200 baud, 8N1."""

TIMES = 20
PIECE = 32
"""The bytes that a parser gets at a time. An FTDI adapter passes up to 62, a UART about 16."""

SLACK = 4096
"""The tolerance of a measurement of memory, in bytes."""


@dataclass(frozen=True)
class StreamResult:
    """The results of a stream: number of values, seconds, and the peaks of memory after a tenth and after all of it."""

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
    options = parser.parse_args()
    rows, are_kept = [], []
    for case in PARSER_CASES:
        for kind, stream_of in STREAMS.items():
            measured = [
                _measure_stream(case, stream_of(case, Random(seed), options.bytes)) for seed in range(options.seeds)
            ]
            times = options.bytes / max(one.seconds for one in measured) / LINE
            are_kept.append(times >= TIMES and all(one.is_flat for one in measured))
            rows.append((case.name, kind, *_format_cells(measured), f"{times:.0f}"))
    print(machine())
    print_table(("parser", "bytes", "values", "most memory, tenth", "most memory, all", "× 115200 baud, least"), rows)
    print(
        f"{options.seeds} seeds of {options.bytes} bytes each; bounds: no exception, memory flat, {TIMES} × 115200 baud"
    )
    return int(not all(are_kept))


def _format_cells(measured: list[StreamResult]) -> tuple[str, str, str]:
    values = sum(one.values for one in measured)
    early, late = (max(getattr(one, name) for one in measured) for name in ("early_peak", "peak"))
    return str(values), f"{early / 1000:.1f} kB", f"{late / 1000:.1f} kB"


def _measure_stream(case: ParserCase, stream: bytes) -> StreamResult:
    began = perf_counter()
    values = _feed(case.parser(), stream)
    seconds = perf_counter() - began
    return StreamResult(values, seconds, _measure_peak(case, stream[: len(stream) // 10]), _measure_peak(case, stream))


def _measure_peak(case: ParserCase, stream: bytes) -> int:
    parser = case.parser()
    tracemalloc.start()
    _feed(parser, stream)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak


def _feed(parser: Parser, stream: bytes) -> int:
    return sum(len(parser.feed(stream[at : at + PIECE])) for at in range(0, len(stream), PIECE))


def _make_noise(_: ParserCase, draw: Random, count: int) -> bytes:
    return draw.randbytes(count)


def _make_marks(case: ParserCase, draw: Random, count: int) -> bytes:
    return bytes(draw.choice(case.start_bytes) if draw.random() < 0.5 else draw.randrange(256) for _ in range(count))


def _make_frames(case: ParserCase, draw: Random, count: int) -> bytes:
    return b"".join(_list_frames(case, draw, count))[:count]


def _list_frames(case: ParserCase, draw: Random, count: int) -> Iterator[bytes]:
    made = 0
    while made < count:
        yield (frame := case.frame(draw))
        made += len(frame)


STREAMS: dict[str, Callable[[ParserCase, Random, int], bytes]] = {
    "random": _make_noise,
    "half of them marks": _make_marks,
    "frames": _make_frames,
}

if __name__ == "__main__":
    sys.exit(main())
