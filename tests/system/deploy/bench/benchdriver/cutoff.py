"""The log of the motors' commands, and a cutoff that writes into it instead of pulling a line low."""

from __future__ import annotations

import os
import time
from pathlib import Path

from robotcore.hal.cutoff import Cutoff

FILE = Path.home() / "wheels.log"
"""The log. Processes only append to it."""


def write_command(source: str, motor: str, rad_s: float) -> None:
    """Append a command to the log: the time in s, the process, the source, the motor and the velocity in rad/s.

    One write per line keeps the lines of several processes apart.
    """
    line = f"{time.monotonic():.3f} {os.getpid()} {source} {motor} {rad_s:g}\n"
    handle = os.open(FILE, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    try:
        os.write(handle, line.encode())
    finally:
        os.close(handle)


class LoggedCutoff(Cutoff):
    """Writes a velocity of 0 for a motor."""

    def __init__(self, motor: str) -> None:
        self._motor = motor

    def open(self) -> None:
        """Do nothing."""

    def stop(self) -> None:
        write_command("cutoff", self._motor, 0.0)

    def close(self) -> None:
        """Do nothing."""
