"""Run the system checks of a deploy: python -m tests.system.deploy [NAME]."""

from __future__ import annotations

import sys
from pathlib import Path

from tests.system import checking, needs
from tests.system.deploy.machine import require_machine

PARALLEL = ("-n", "3", "--dist", "loadfile")
"""Options of pytest: three files at a time, each with a robot of its own, because the checks mostly wait."""


def main(names: list[str]) -> bool:
    """Run these files of checks, by default all; return whether every check passed."""
    require_machine()
    return checking.run(Path(__file__).parent / "checks", names, *PARALLEL)


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("deploy", lambda: main(sys.argv[1:])))
