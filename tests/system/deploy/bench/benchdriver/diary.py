"""What every motor of the bench was told, by whom and when: a file that is only ever added to."""

from __future__ import annotations

import os
import time
from pathlib import Path

FILE = Path.home() / "wheels.log"


def note(who: str, motor: str, rad_s: float) -> None:
    """Add a line that no other process's falls into: the time in s, the process, who it is, which motor, how fast."""
    line = f"{time.monotonic():.3f} {os.getpid()} {who} {motor} {rad_s:g}\n"
    handle = os.open(FILE, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    try:
        os.write(handle, line.encode())
    finally:
        os.close(handle)
