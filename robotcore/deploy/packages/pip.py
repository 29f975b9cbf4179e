"""pip, as this Python has it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec

from robotcore.errors import DeployError


def pip(words: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run pip, quietly, and return what it said; the user's own configuration of it holds. Raises DeployError."""
    if find_spec("pip") is None:
        raise DeployError("pip is not installed here. Run python -m ensurepip")
    return subprocess.run(  # noqa: S603  words, and no shell to take them for anything else
        [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input", "--no-color", *words],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="backslashreplace",
        check=False,
    )


def told(asked: subprocess.CompletedProcess[str]) -> str:
    """Return what pip said went wrong: its last line that says error, or its last line."""
    lines = [line.strip() for line in asked.stderr.splitlines() if line.strip()]
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    return (errors or lines or [f"exit status {asked.returncode}"])[-1]
