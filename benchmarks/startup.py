"""Measure the time of ``robotcore --help`` against that of importing NumPy. The bound is a ratio of 2.

    python -m benchmarks.startup

Both are started in turn, so that other load on the machine affects both. The exit status is 1 if the bound is broken.
"""

from __future__ import annotations

import argparse
import math
import statistics
import subprocess
import sys
from time import perf_counter

from benchmarks.report import at_least_one, machine, print_table

BOUND = 2.0
NUMPY = ("-c", "import numpy")
HELP = ("-m", "robotcore", "--help")


def main() -> int:
    """Measure the pairs of starts, and print their medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=at_least_one, default=40)
    count = parser.parse_args().pairs
    for arguments in (NUMPY, HELP):
        _milliseconds(*arguments)
    pairs = [(_milliseconds(*NUMPY), _milliseconds(*HELP)) for _ in range(count)]
    ratios = [ours / numpy for numpy, ours in pairs]
    print(machine())
    print_table(
        ("command", f"median of {count}", "95 % interval"),
        [
            ("python -c 'import numpy'", *_format_cells([numpy for numpy, _ in pairs], "{:.1f} ms")),
            ("python -m robotcore --help", *_format_cells([ours for _, ours in pairs], "{:.1f} ms")),
            (f"ratio within a pair, at most {BOUND:g}", *_format_cells(ratios, "{:.2f}")),
        ],
    )
    return int(statistics.median(ratios) > BOUND)


def _milliseconds(*arguments: str) -> float:
    start = perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)  # noqa: S603
    return 1000 * (perf_counter() - start)


def _format_cells(values: list[float], form: str) -> tuple[str, str]:
    ordered = sorted(values)
    reach = 0.98 * math.sqrt(len(ordered))
    low = max(math.floor(len(ordered) / 2 - reach), 0)
    high = min(math.ceil(len(ordered) / 2 + reach), len(ordered) - 1)
    return form.format(statistics.median(ordered)), f"{form.format(ordered[low])} to {form.format(ordered[high])}"


if __name__ == "__main__":
    sys.exit(main())
