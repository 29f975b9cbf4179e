"""The folder and the environment of a Jupyter kernel in a test."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest


@pytest.fixture
def kernel_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty folder for a kernel, which finds the commands of this Python, and no settings of the user."""
    settings = tmp_path / ".jupyter"
    for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR"):
        monkeypatch.setenv(name, str(settings))
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    return tmp_path
