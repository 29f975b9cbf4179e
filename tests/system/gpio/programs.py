"""The programs in C of the guest, fast enough for short pulses: an ultrasonic module, and wires."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.system import needs

FOLDER = Path(__file__).parent


def build_program(name: str) -> Path:
    """Compile the program ``name``, and return its path."""
    program = needs.cache() / name
    subprocess.run(["gcc", "-O2", "-Wall", "-Werror", "-o", program, FOLDER / f"{name}.c"], check=True)
    return program
