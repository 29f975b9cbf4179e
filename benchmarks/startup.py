"""Measure the time of ``robotcore --help`` against that of importing NumPy. The bound is a ratio of 2.

    python -m benchmarks.startup

Both are started in turn, so that other load on the machine affects both. The exit status is 1 if the bound is broken.
"""

from __future__ import annotations

import subprocess
import sys
from time import perf_counter

from benchmarks.report import compute_median, measure_ratio, parse_options, print_table

BOUND = 2.0
NUMPY = ("-c", "import numpy")
HELP = ("-m", "robotcore", "--help")


def main() -> int:
    """Measure the pairs of starts, and print their medians."""
    options = parse_options(__doc__, pairs=40)
    numpy, ours = list[float](), list[float]()
    for arguments in (NUMPY, HELP):
        _time_ms(arguments, [])
    ratio = measure_ratio(lambda: _time_ms(HELP, ours), lambda: _time_ms(NUMPY, numpy), options.pairs)
    rows = [
        ("python -c 'import numpy', ms", *compute_median(numpy).format_cells(".1f")),
        ("python -m robotcore --help, ms", *compute_median(ours).format_cells(".1f")),
        (f"ratio within a pair, at most {BOUND:g}", *ratio.format_cells(".2f")),
    ]
    print_table((f"{options.pairs} pairs", "median", "95 % interval"), rows)
    return int(ratio.median > BOUND)


def _time_ms(arguments: tuple[str, ...], times: list[float]) -> float:
    start = perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)  # noqa: S603  our own
    times.append(1000 * (perf_counter() - start))
    return times[-1]


if __name__ == "__main__":
    sys.exit(main())
