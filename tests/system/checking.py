"""Run files of checks on a real simulator, whose address is in an environment variable."""

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
"""The time limit of a check, on the reference machine."""


def read_address(variable: str) -> Address | None:
    """Return the address HOST:PORT in an environment variable; None if it is not set."""
    host, _, port = os.environ.get(variable, "").rpartition(":")
    return Address(host=host or "127.0.0.1", port=int(port)) if port else None


def run(folder: Path, names: Iterable[str], *options: str) -> bool:
    """Run files of checks; return whether every check passed. Their temporary files are removed.

    folder: the folder of the files.
    names: the files without their suffix; by default all.
    options: for pytest.
    """
    files = [folder / f"{name}.py" for name in names] or sorted(folder.glob("[a-z]*.py"))
    plugins = ["-p", "no:cacheprovider", f"--timeout={scaled(CHECK_LIMIT_S):.0f}"]
    with TemporaryDirectory(prefix="robotcore-checks-", ignore_cleanup_errors=True) as scratch:
        plugins += [f"--basetemp={scratch}/pytest"]
        command = [sys.executable, "-m", "pytest", *plugins, "-v", "-rs", *options, *map(str, files)]
        environment = {**os.environ, "TMPDIR": scratch}
        return subprocess.run(command, cwd=needs.ROOT, env=environment, check=False).returncode == 0
