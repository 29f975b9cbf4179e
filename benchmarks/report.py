"""The output of every benchmark: the machine, the date, the command, and a table."""

from __future__ import annotations

import argparse
import platform
import sys
from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path


def machine() -> str:
    """Return two lines: the processor, the system, the Python version and the date, then the command."""
    command = " ".join(["python -m", f"benchmarks.{Path(sys.argv[0]).stem}", *sys.argv[1:]])
    date = f"{datetime.now():%Y-%m-%d}"
    return f"{_describe_processor()}, {platform.system()}, Python {platform.python_version()}, {date}\n$ {command}"


def at_least_one(text: str) -> int:
    """Parse a whole number from 1 on, as a type of argparse."""
    if not (text.isdecimal() and (size := int(text))):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number from 1")
    return size


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table in Markdown."""
    cells = [list(columns), ["---"] * len(columns), *map(list, rows)]
    print("\n".join(f"| {' | '.join(row)} |" for row in cells))


def _describe_processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0]} ×{len(names)}" if names else platform.machine()
