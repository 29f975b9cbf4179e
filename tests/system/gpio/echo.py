"""The ultrasonic module of the guest: a program in C, fast enough for a pulse of ten microseconds."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.system import needs

SOURCE = Path(__file__).with_suffix(".c")


def build_echo() -> Path:
    """Compile the program, and return its path."""
    program = needs.cache() / "echo"
    subprocess.run(["gcc", "-O2", "-Wall", "-Werror", "-o", program, SOURCE], check=True)
    return program
