"""The options and the output of every benchmark, and medians of durations that are measured in pairs."""

from __future__ import annotations

import argparse
import math
import platform
import statistics
import sys
from collections.abc import Callable, Iterable, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import NamedTuple


def parse_options(text: str, **defaults: float | str | bool) -> argparse.Namespace:
    """Parse the command line, and print the machine, the date and the command.

    text: the docstring of the benchmark.
    defaults: the default of each option. A whole number has the minimum 1, or 0 if its default is 0. False is a flag.
    """
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in defaults.items():
        if default is False:
            parser.add_argument(f"--{name}", action="store_true")
        else:
            parse = partial(parse_whole, min(default, 1)) if isinstance(default, int) else type(default)
            parser.add_argument(f"--{name}", type=parse, default=default, help=f"default: {default}")
    options = parser.parse_args()
    print_machine()
    return options


def parse_whole(least: int, text: str) -> int:
    """Parse a whole number from ``least`` on, as a type of argparse."""
    if not (text.isdecimal() and (number := int(text)) >= least):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number from {least}")
    return number


def print_machine() -> None:
    """Print the processor, the system, the Python version and the date, then the command."""
    command = " ".join(["python -m", f"benchmarks.{Path(sys.argv[0]).stem}", *sys.argv[1:]])
    date = f"{datetime.now():%Y-%m-%d}"
    print(f"{_describe_processor()}, {platform.system()}, Python {platform.python_version()}, {date}\n$ {command}")


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table in Markdown."""
    cells = [list(columns), ["---"] * len(columns), *map(list, rows)]
    print("\n".join(f"| {' | '.join(row)} |" for row in cells))


class Interval(NamedTuple):
    """A median, and the ends of its 95 % interval."""

    median: float
    low: float
    high: float

    def format_cells(self, form: str) -> tuple[str, str]:
        """Return the cells of a table: the median, and the interval. ``form`` formats a number, such as ``.2f``."""
        return f"{self.median:{form}}", f"{self.low:{form}} to {self.high:{form}}"


def compute_median(values: Iterable[float]) -> Interval:
    """Return the median, and the ends of its 95 % interval, which are two of the values.

    The number of values below the true median is binomial with p = 1/2 (the sign test). With less than six values, no
    interval is so certain. The function then returns the least and the greatest value.
    """
    ordered = sorted(values)
    left_out, below = 0, 1
    while 40 * below <= 2 ** len(ordered):
        left_out += 1
        below += math.comb(len(ordered), left_out)
    outside = max(left_out - 1, 0)
    return Interval(statistics.median(ordered), ordered[outside], ordered[-1 - outside])


def measure_ratio(first: Callable[[], float], second: Callable[[], float], pairs: int) -> Interval:
    """Return the median of ``first() / second()``.

    first: a function that measures a duration in seconds.
    second: the function that measures the other duration.

    The two functions of a pair are called right after each other, in alternating order. So other load on the machine
    affects both.
    """
    ratios = []
    for pair in range(pairs):
        if pair % 2:
            below = second()
            ratios.append(first() / below)
        else:
            above = first()
            ratios.append(above / second())
    return compute_median(ratios)


def _describe_processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0]} ×{len(names)}" if names else platform.machine()
