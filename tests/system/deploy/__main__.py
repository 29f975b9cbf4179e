"""Deploy to a Debian that systemd boots: python -m tests.system.deploy [NAME]."""

from __future__ import annotations

import sys
from pathlib import Path

from tests.system import checking, needs
from tests.system.deploy.machine import require_machine

SIDE_BY_SIDE = ("-n", "3", "--dist", "loadfile")
"""Each has a target of its own; most of the time they wait for what comes."""


def main(names: list[str]) -> bool:
    """Run these files of checks, by default all; return whether every check was passed."""
    require_machine()
    return checking.run(Path(__file__).parent / "checks", names, *SIDE_BY_SIDE)


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("deploy", lambda: main(sys.argv[1:])))
