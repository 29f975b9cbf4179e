"""The user's own systemd."""

from __future__ import annotations

import os
import subprocess

PATIENCE_S = 60


def systemctl(*arguments: str) -> str:
    """Return what systemctl printed; whether it did what it was told is asked by ``is-active`` and the like."""
    environment = {"XDG_RUNTIME_DIR": f"/run/user/{os.getuid()}", **os.environ}
    command = ["systemctl", "--user", *arguments]
    told = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=PATIENCE_S, check=False)  # noqa: S603
    return told.stdout
