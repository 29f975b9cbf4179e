"""The simulator: our program on simavr's library, compiled here."""

from __future__ import annotations

import subprocess
from pathlib import Path

SOURCES = Path(__file__).with_name("avr")
PACKAGES = ("gcc", "libc6-dev", "libsimavr-dev", "libelf-dev")
FLAGS = ("-O2", "-std=gnu11", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror")


def build_simulator(folder: Path) -> Path:
    """Compile it into a folder, and return where it is; see avr/main.c for what it is given."""
    program = folder / "simulated-avr"
    sources = sorted(map(str, SOURCES.glob("*.c")))
    subprocess.run(["gcc", *FLAGS, "-o", program, *sources, "-lsimavr", "-lm"], check=True)
    return program
