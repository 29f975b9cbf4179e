from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

TypeCommand = Callable[..., "subprocess.CompletedProcess[str]"]

HOME = Path(__file__).parents[4]
"""The folder that has the packages robotcore, drivers and apps."""


@pytest.fixture
def type_command() -> TypeCommand:
    """Return a function that runs ``python -m COMMAND`` in a folder, with robotcore installed."""

    def run(folder: Path, *command: str, path: str = "") -> subprocess.CompletedProcess[str]:
        found = os.pathsep.join(filter(None, (str(HOME), path)))
        environment = {**os.environ, "PYTHONPATH": found, "PYTHONDONTWRITEBYTECODE": "1"}
        return subprocess.run(
            [sys.executable, "-m", *command],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )

    return run
