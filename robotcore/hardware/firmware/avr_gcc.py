"""Building the sketch with plain avr-gcc and the Arduino core of Debian's package arduino-core-avr.

The recipe is that of the core's platform.txt, without link-time optimisation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from robotcore.hardware.firmware.boards import Board
from robotcore.hardware.firmware.tools import found, run

TOOL = "avr-gcc"
CORE = Path("/usr/share/arduino/hardware/arduino/avr")
DEBIAN_PACKAGES = "gcc-avr arduino-core-avr"

_COMMON = ("-c", "-g", "-Os", "-mmcu=atmega328p", "-ffunction-sections", "-fdata-sections")
_CPP = ("-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics")
_DEFINED = ("F_CPU=16000000L", "ARDUINO=10819", "ARDUINO_ARCH_AVR", "DECIMAL_DIG=10")
"""The compiler defines no DECIMAL_DIG before version 7, and the core needs it."""


def is_here() -> bool:
    """Return whether the compiler and the core are installed."""
    return found("avr-gcc", "avr-g++", "avr-objcopy") and (CORE / "cores" / "arduino" / "Arduino.h").is_file()


def build(sketch: Path, board: Board, folder: Path, *, flags: Sequence[str] = ()) -> Path:
    """Compile a sketch into FOLDER/NAME.elf and NAME.hex; return the latter.

    A sketch's .ino files become one; no prototypes are made up for it, so what it calls must be declared.
    ``flags`` are the compiler's for the sketch itself. Raises FirmwareError with what it said.
    """
    folder.mkdir(parents=True, exist_ok=True)
    joined = _joined(sketch, folder)
    core = CORE / "cores" / "arduino"
    ours = [joined, *sorted(sketch.glob("*.cpp"))]
    theirs = [path for path in sorted(core.iterdir()) if path.suffix in {".c", ".cpp", ".S"}]
    with ThreadPoolExecutor() as pool:
        compiled = partial(_compiled, board, sketch, folder)
        objects = [*pool.map(partial(compiled, flags), ours), *pool.map(partial(compiled, ["-w"]), theirs)]
    return _linked(objects, folder / sketch.name)


def _joined(sketch: Path, folder: Path) -> Path:
    """Write a sketch's .ino files as one of C++: first the one of the sketch's name, then in order."""
    first = sketch / f"{sketch.name}.ino"
    others = sorted(path for path in sketch.glob("*.ino") if path != first)
    joined = folder / f"{sketch.name}.ino.cpp"
    joined.write_text("#include <Arduino.h>\n" + "".join(map(_numbered, (first, *others))))
    return joined


def _numbered(source: Path) -> str:
    """Return a file's text, of which the compiler speaks by that file's name."""
    return f'#line 1 "{source}"\n{source.read_text()}\n'


def _compiled(board: Board, sketch: Path, folder: Path, flags: Sequence[str], source: Path) -> Path:
    target = folder / f"{source.name}.o"
    compiler = "avr-g++" if source.suffix == ".cpp" else "avr-gcc"
    command = [compiler, *_flags(source, board), *flags, f"-I{sketch}", str(source), "-o", str(target)]
    run(command, f"compiling {source.name}")
    return target


def _flags(source: Path, board: Board) -> Iterator[str]:
    yield from _COMMON
    yield from _CPP if source.suffix == ".cpp" else ()
    yield from ("-x", "assembler-with-cpp") if source.suffix == ".S" else ()
    yield from (f"-D{macro}" for macro in (*_DEFINED, board.macro))
    yield from (f"-I{CORE / 'cores' / 'arduino'}", f"-I{CORE / 'variants' / board.variant}")


def _linked(objects: list[Path], target: Path) -> Path:
    elf, image = target.with_suffix(".elf"), target.with_suffix(".hex")
    run(["avr-gcc", "-mmcu=atmega328p", "-Os", "-Wl,--gc-sections", *objects, "-lm", "-o", elf], f"linking {elf.name}")
    run(["avr-objcopy", "-O", "ihex", "-R", ".eeprom", elf, image], f"writing {image.name}")
    return image
