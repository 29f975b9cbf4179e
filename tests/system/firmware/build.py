"""Build the firmware for a simulated board, with the wiring of a robot."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

from robotcore.hardware.firmware import toolchain
from robotcore.hardware.firmware.board import BOARDS, shipped_sketch
from tests.system import needs
from tests.system.firmware.config import ROVER

STRICT = ("-Wall", "-Wextra", "-Werror")
"""The compiler's options for robotcore_bridge, which has no warnings."""


def build(folder: Path, config: Mapping[str, object] | None = None, sketch: Path | None = None) -> Path:
    """Build a sketch, by default robotcore_bridge, in a folder; return the ELF file.

    config: new values in a copy of its config.h, such as ``{"BATTERY_PIN": "A0"}``.
    Raises FirmwareError with the compiler's output, or if avr-gcc is not installed.
    """
    source = sketch or shipped_sketch()
    copy = folder / source.name
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(source, copy)
    for name, value in (config or {}).items():
        _define(copy / "config.h", name, value)
    image = toolchain.build_with_avr_gcc(copy, BOARDS["uno"], folder / "objects", flags=[] if sketch else STRICT)
    return image.with_suffix(".elf")


def _define(header: Path, name: str, value: object) -> None:
    text, changes = re.subn(rf"(?m)^(#define {name}) .*$", rf"\1 {value}", header.read_text())
    if changes != 1:
        raise LookupError(f"{header}: has {changes} lines `#define {name}`")
    header.write_text(text)


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
    """Build the simulator and the sketch in a folder that is also on Python's path.

    Raises NotRunError if a package is missing and cannot be installed."""
    if not _has_tools():
        needs.debian()
        needs.packages(*PACKAGES)
    build_simulator(folder)
    shutil.copy(build(folder, ROVER), folder / "firmware.elf")
    package = folder / "robotcore_simavr-0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text(METADATA)
    (package / "entry_points.txt").write_text(ENTRY)


def build_simulator(folder: Path) -> Path:
    """Compile the simulator in a folder, and return its path. avr/main.c describes its arguments."""
    program = folder / "simulated-avr"
    sources = sorted(map(str, SOURCES.glob("*.c")))
    subprocess.run(["gcc", *FLAGS, "-o", program, *sources, "-lsimavr", "-lm"], check=True)
    return program


def _has_tools() -> bool:
    return all(map(shutil.which, ("gcc", "avr-g++"))) and all(map(os.path.exists, NEEDED))
