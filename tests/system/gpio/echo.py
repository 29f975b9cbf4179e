"""The ultrasonic sensor of the guest: a program in C, quick enough to see a pulse of ten microseconds."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.system import needs

SOURCE = Path(__file__).with_suffix(".c")


def build_echo() -> Path:
    """Compile the program, and return where it is."""
    program = needs.cache() / "echo"
    subprocess.run(["gcc", "-O2", "-Wall", "-Werror", "-o", program, SOURCE], check=True)
    return program
