"""Run the checks of robotcore_bridge on a simulated AVR: python -m tests.system.firmware [NAME]."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.system import checking, needs
from tests.system.firmware import build as installing
from tests.system.firmware.backend import BUILT

SIDE_BY_SIDE = 2
"""Each check has its own board, which uses half a core."""


def main(names: list[str]) -> bool:
    """Build the firmware and the simulator, and run these files of checks, by default all; return if all passed."""
    with TemporaryDirectory(prefix="robotcore-firmware-") as folder:
        installing.install(Path(folder))
        os.environ[BUILT] = folder
        os.environ["PYTHONPATH"] = os.pathsep.join([str(needs.ROOT), folder])  # for finding the backend by name
        spread = ["-n", str(SIDE_BY_SIDE), "--dist", "worksteal"]
        return checking.run(Path(__file__).parent / "checks", names, *spread)


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("firmware", lambda: main(sys.argv[1:])))
