"""What the checks run on: the simulator, our firmware, and the backend as a package that robotcore finds by name."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from tests.system import needs
from tests.system.firmware.build import build
from tests.system.firmware.config import ROVER

SOURCES = Path(__file__).with_name("avr")
FLAGS = ("-O2", "-std=gnu11", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror")
PACKAGES = ("gcc", "libc6-dev", "libsimavr-dev", "gcc-avr", "avr-libc", "arduino-core-avr")
NEEDED = (
    Path("/usr/include/simavr/sim_avr.h"),
    Path("/usr/share/arduino/hardware/arduino/avr/cores/arduino/Arduino.h"),
)
ENTRY = "[robotcore.backends]\nsimavr = tests.system.firmware.backend:SimavrBackend\n"
METADATA = "Metadata-Version: 2.1\nName: robotcore-simavr\nVersion: 0\n"


def install(folder: Path) -> None:
    """Build all of it in a folder, which Python is to look in too; raises NotRunError where that cannot be done."""
    if not _is_here():
        needs.debian()
        needs.packages(*PACKAGES)
    build_simulator(folder)
    shutil.copy(build(folder, ROVER), folder / "firmware.elf")
    package = folder / "robotcore_simavr-0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text(METADATA)
    (package / "entry_points.txt").write_text(ENTRY)


def build_simulator(folder: Path) -> Path:
    """Compile the simulator in a folder, and return where it is; see avr/main.c for what it is given."""
    program = folder / "simulated-avr"
    sources = sorted(map(str, SOURCES.glob("*.c")))
    subprocess.run(["gcc", *FLAGS, "-o", program, *sources, "-lsimavr", "-lm"], check=True)
    return program


def _is_here() -> bool:
    """Whether all that is needed is installed, on whatever system."""
    return all(map(shutil.which, ("gcc", "avr-g++"))) and all(map(os.path.exists, NEEDED))
