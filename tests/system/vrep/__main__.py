"""Run the checks on the legacy remote API that ROBOTCORE_VREP names: python -m tests.system.vrep [NAME]."""

from __future__ import annotations

import sys
from pathlib import Path

from tests.system import checking, needs
from tests.system.vrep.server import VARIABLE, address


def main(names: list[str]) -> bool:
    """Run the named files of checks, or all; return whether all checks passed."""
    if address() is None:
        raise needs.NotRunError(f"needs a CoppeliaSim with an empty scene. Set {VARIABLE}=HOST:PORT")
    return checking.run(Path(__file__).parent / "checks", names)


if __name__ == "__main__":
    sys.exit(needs.run_or_skip("vrep", lambda: main(sys.argv[1:])))
