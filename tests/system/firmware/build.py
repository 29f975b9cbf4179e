"""Build the firmware for a simulated board, with the wiring of a robot."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from robotcore.hardware.firmware.board import shipped_sketch
from robotcore.hardware.firmware.toolchain import run_tool
from tests.system import needs
from tests.system.firmware.config import ROVER

STRICT = ("-Wall", "-Wextra", "-Werror")
"""The compiler's options for robotcore_bridge, which has no warnings."""


AVR = Path("/usr/share/arduino/hardware/arduino/avr")
"""The Arduino core of Debian's package arduino-core-avr. arduino-cli is not in Debian."""

CORE = AVR / "cores" / "arduino"
MCU = "-mmcu=atmega328p"
COMMON = (
    *("-c", "-g", "-Os", MCU, "-ffunction-sections", "-fdata-sections"),
    *("-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_ARCH_AVR", "-DARDUINO_AVR_UNO"),
    "-DDECIMAL_DIG=10",  # avr-gcc before version 7 does not define it
    *(f"-I{CORE}", f"-I{AVR / 'variants' / 'standard'}"),
)
CPP = ("-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics")
"""The options of the core's platform.txt without link-time optimisation."""


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
    (objects := folder / "objects").mkdir(exist_ok=True)
    joined = objects / f"{copy.name}.ino.cpp"
    joined.write_text(
        "#include <Arduino.h>\n"
        + "".join(map(_read_sketch, sorted(copy.glob("*.ino"), key=lambda path: path.stem != copy.name)))
    )
    own = [joined, *sorted(copy.glob("*.cpp"))]
    core = [path for path in sorted(CORE.iterdir()) if path.suffix in {".c", ".cpp", ".S"}]
    flags = () if sketch else STRICT
    with ThreadPoolExecutor() as pool:
        compiled = [
            *pool.map(partial(_compile, objects, (*flags, f"-I{copy}")), own),
            *pool.map(partial(_compile, objects, ("-w",)), core),
        ]
    elf = folder / f"{copy.name}.elf"
    run_tool(["avr-gcc", MCU, "-Os", "-Wl,--gc-sections", *compiled, "-lm", "-o", elf], f"linking {elf.name}")
    return elf


def _read_sketch(source: Path) -> str:
    # Errors of the compiler then name the original file.
    return f'#line 1 "{source}"\n{source.read_text()}\n'


def _compile(folder: Path, flags: Sequence[str], source: Path) -> Path:
    target = folder / f"{source.name}.o"
    is_cpp = source.suffix == ".cpp"
    command = ["avr-g++" if is_cpp else "avr-gcc", *COMMON, *(CPP if is_cpp else ()), *flags, source, "-o", target]
    if source.suffix == ".S":
        command[1:1] = ["-x", "assembler-with-cpp"]
    run_tool(command, f"compiling {source.name}")
    return target


def _define(header: Path, name: str, value: object) -> None:
    text, changes = re.subn(rf"(?m)^(#define {name}) .*$", rf"\1 {value}", header.read_text())
    if changes != 1:
        raise LookupError(f"{header}: has {changes} lines `#define {name}`")
    header.write_text(text)


SOURCES = Path(__file__).with_name("avr")
FLAGS = ("-O2", "-std=gnu11", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror")
PACKAGES = ("gcc", "libc6-dev", "libsimavr-dev", "gcc-avr", "avr-libc", "arduino-core-avr")
SIMAVR = Path("/usr/include/simavr/sim_avr.h")
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


def has_avr_gcc() -> bool:
    """Return whether avr-gcc and the Arduino core are installed."""
    return shutil.which("avr-g++") is not None and (CORE / "Arduino.h").is_file()


def _has_tools() -> bool:
    return has_avr_gcc() and shutil.which("gcc") is not None and SIMAVR.exists()
