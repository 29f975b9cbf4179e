"""Checks on a real simulator: where it listens, as the environment says, and how files of checks are run."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

from drivers.coppeliasim.address import Address
from tests.system import needs
from tests.system.speed import scaled

CHECK_LIMIT_S = 600
"""Of a check, on the reference machine: a hang."""


def address_in(variable: str) -> Address | None:
    """Return where the simulator listens that a variable names as HOST:PORT; None where it names none."""
    host, _, port = os.environ.get(variable, "").rpartition(":")
    return Address(host=host or "127.0.0.1", port=int(port)) if port else None


def run(folder: Path, names: Iterable[str], *options: str) -> bool:
    """Run these files of checks of a folder, by default all; return whether every check was passed.

    ``options`` are pytest's. What checks and the programs they kill leave among temporary files is removed.
    """
    files = [folder / f"{name}.py" for name in names] or sorted(folder.glob("[a-z]*.py"))
    plugins = ["-p", "no:cacheprovider", f"--timeout={scaled(CHECK_LIMIT_S):.0f}"]
    with TemporaryDirectory(prefix="robotcore-checks-", ignore_cleanup_errors=True) as scratch:
        plugins += [f"--basetemp={scratch}/pytest"]
        command = [sys.executable, "-m", "pytest", *plugins, "-v", "-rs", *options, *map(str, files)]
        environment = {**os.environ, "TMPDIR": scratch}
        return subprocess.run(command, cwd=needs.ROOT, env=environment, check=False).returncode == 0
