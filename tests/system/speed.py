"""How slow this machine is, and limits of time that hold on it.

Every limit of the system tests is stated for the reference machine: two idle cores of an AMD EPYC of 2024. A virtual
machine measures its own speed.
"""

from __future__ import annotations

import os
import subprocess
import sys
from time import monotonic

VARIABLE = "ROBOTCORE_SLOWNESS"
"""Holds the measured slowness for the processes that this one starts. A user may set it, to give more time."""

REFERENCE_S = 0.2
"""How long the work takes on the reference machine."""

WORK = "sum(number * number for number in range(1_500_000))"
AT_ONCE = 2
"""A share of the machine's time is seen only when all cores are wanted."""


def slowness() -> float:
    """Return how many times longer work takes here than on the reference machine: at least 1, measured once."""
    if VARIABLE not in os.environ:
        os.environ[VARIABLE] = f"{max(1.0, work_s() / REFERENCE_S):.2f}"
    given = os.environ[VARIABLE]
    try:
        return max(1.0, float(given))
    except ValueError:
        sys.exit(f"{VARIABLE} is {given!r}, which is no number; set it to how many times slower this machine is: 3")


def scaled(limit_s: float) -> float:
    """Return a limit that is stated for the reference machine as it holds on this one."""
    return limit_s * slowness()


def work_s() -> float:
    """Return how long it takes to start Python and let it calculate, on several cores at once."""
    start = monotonic()
    running = [subprocess.Popen([sys.executable, "-S", "-c", WORK]) for _ in range(AT_ONCE)]
    for process in running:
        process.wait()
    return monotonic() - start
