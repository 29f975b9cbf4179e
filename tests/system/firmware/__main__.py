"""Run the checks of robotcore_bridge on a simulated AVR: python -m tests.system.firmware [NAME]."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.system import checking, needs
from tests.system.firmware import build as installing
from tests.system.firmware.backend import BUILT

PARALLEL_CHECKS = 2
"""The number of checks at a time. Each has its own board, which uses half a core."""


def main(names: list[str]) -> bool:
    """Build the firmware and the simulator, and run the checks.

    names: the files of checks; empty runs all.
    Returns whether all passed."""
    with TemporaryDirectory(prefix="robotcore-firmware-") as folder:
        installing.install(Path(folder))
        os.environ[BUILT] = folder
        os.environ["PYTHONPATH"] = os.pathsep.join([str(needs.ROOT), folder])  # to find the backend
        spread = ["-n", str(PARALLEL_CHECKS), "--dist", "worksteal"]
        return checking.run(Path(__file__).parent / "checks", names, *spread)


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("firmware", lambda: main(sys.argv[1:])))
