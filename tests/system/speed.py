"""Measure how slow this machine is, and scale time limits by that.

The time limits of the system tests are stated for the reference machine: two idle cores of an AMD EPYC of 2024. A
virtual machine measures its own speed.
"""

from __future__ import annotations

import os
import subprocess
import sys
from time import monotonic

VARIABLE = "ROBOTCORE_SLOWNESS"
"""The environment variable that passes the measured factor to child processes. A user may set it for more time."""

REFERENCE_S = 0.2
"""The time of the work on the reference machine."""

WORK = "sum(number * number for number in range(1_500_000))"
AT_ONCE = 2
"""Processes that work at the same time, because a limited share of the machine's time shows only then."""


def slowness() -> float:
    """Return the factor by which this machine is slower than the reference machine: at least 1, measured once."""
    if VARIABLE not in os.environ:
        os.environ[VARIABLE] = f"{max(1.0, measure_work() / REFERENCE_S):.2f}"
    given = os.environ[VARIABLE]
    try:
        return max(1.0, float(given))
    except ValueError:
        sys.exit(f"{VARIABLE} is {given!r}, which is no number. Set it to this machine's slowness, such as 3")


def scaled(limit_s: float) -> float:
    """Return a time limit of the reference machine, scaled to this machine."""
    return limit_s * slowness()


def measure_work() -> float:
    """Return the seconds that starting Python and a calculation take, on several cores at once."""
    start = monotonic()
    running = [subprocess.Popen([sys.executable, "-S", "-c", WORK]) for _ in range(AT_ONCE)]
    for process in running:
        process.wait()
    return monotonic() - start
