"""Run the checks on the CoppeliaSim that ROBOTCORE_COPPELIASIM names: python -m tests.system.coppeliasim [NAME]."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.system import needs
from tests.system.coppeliasim.server import VARIABLE, address

CHECKS = Path(__file__).parent / "checks"
CHECK_LIMIT_S = 600


def main(names: list[str]) -> bool:
    """Run these files of checks, by default all; return whether every check was passed."""
    if address() is None:
        raise needs.NotRunError(f"needs a CoppeliaSim with an empty scene; tell where it listens: {VARIABLE}=HOST:PORT")
    files = [CHECKS / f"{name}.py" for name in names] or sorted(CHECKS.glob("[a-z]*.py"))
    plugins = ["-p", "no:cacheprovider", f"--timeout={CHECK_LIMIT_S}"]
    command = [sys.executable, "-m", "pytest", *plugins, "-v", *map(str, files)]
    return subprocess.run(command, cwd=needs.ROOT, check=False).returncode == 0


if __name__ == "__main__":
    sys.exit(needs.told("coppeliasim", lambda: main(sys.argv[1:])))
