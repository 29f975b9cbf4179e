from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

Typed = Callable[..., "subprocess.CompletedProcess[str]"]

HOME = Path(__file__).parents[4]
"""Where robotcore, drivers and apps are."""


@pytest.fixture
def typed() -> Typed:
    """Type a command of Python's in a folder, as a user does, who has robotcore installed."""

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
